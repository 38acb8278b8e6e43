// @ts-check
// The fast runs of a panel: mice that drive along several routes in real time, as ghosts of each other. While they are
// shown, they replace the states of the search.

import * as api from "./api.js";
import { cloneTemplate, query, recall, remember, setAttributes, setText, sleep } from "./dom.js";
import { FastRunChart, formatAcceleration, formatSpeed } from "./fast_run_chart.js";
import { FastRunMap, drawScale } from "./fast_run_map.js";
import { FastRunPlayer } from "./fast_run_player.js";
import { Trajectory } from "./trajectory.js";

/**
 * @typedef {api.RouteRun["route"]} RouteName
 * `colour` is the class of a colour.
 * @typedef {{ name: RouteName, colour: string, trajectory: Trajectory | null, error: string }} RouteState
 */

/** The name and the description of each route. @type {Record<RouteName, [string, string]>} */
const ROUTES = {
  fastest: ["Fastest", "The fastest of all runs through the maze, proven"],
  "fewest-cells": ["Fewest cells", "The fastest run along a route with the fewest cells"],
  "fewest-turns": ["Fewest turns", "The fastest run along a route with the fewest turns"],
  "known-walls": ["Known walls", "The fastest run over the walls that the mouse knows"],
  driven: ["Driven", "The latest run that the mouse has driven with slalom turns"],
};
/** The routes that depend on the shown state. @type {RouteName[]} */
const OF_MOUSE = ["known-walls", "driven"];
/** Minimum time between requests for the run over known walls, in milliseconds. */
const KNOWN_PAUSE = 300;

export class FastRun {
  /** True if the fast runs are shown. */
  isOn = false;
  #panel;
  #area;
  #details;
  #player;
  #chart;
  #vehicle;
  /** @type {FastRunMap | null} */
  #map = null;
  /** The source whose runs are loaded. @type {api.Source | null} */
  #source = null;
  #abort = new AbortController();
  /** @type {RouteState[]} */
  #routes = [];
  /** The names of the shown routes. @type {Set<RouteName>} */
  #shown = new Set(/** @type {RouteName[]} */ (["fastest", "fewest-cells", "fewest-turns"]));
  /** The route that is coloured by speed. @type {RouteName} */
  #selected = "fastest";
  /** True if the user has chosen a route. */
  #isChosen = false;
  /** The last source whose driven run was selected. @type {api.Source | null} */
  #drivenOf = null;
  /** The index of the state of the run over known walls, or -1. */
  #knownAt = -1;
  #isLoadingKnown = false;

  /** @param {import("./panel.js").Panel} panel @param {api.PageInfo} info */
  constructor(panel, { vehicles }) {
    this.#panel = panel;
    this.#area = query(panel.element, ".drive");
    this.#details = query(panel.element, ".drive-details");
    this.#player = new FastRunPlayer(this.#area, (time) => this.#move(time));
    this.#chart = new FastRunChart(this.#area, this.#player.axis, (time) => this.#player.seek(time));
    this.#vehicle = query(this.#details, "[name=vehicle]", HTMLSelectElement);
    this.#vehicle.replaceChildren(...vehicles.map((name) => new Option(name)));
    this.#vehicle.disabled = vehicles.length === 1; // an exported page has the times of one vehicle
    this.#vehicle.onchange = () => {
      remember("vehicle", this.#vehicle.value);
      document.dispatchEvent(new Event("vehicle"));
    };
    // All panels time their mice with the same vehicle.
    document.addEventListener("vehicle", () => {
      if (!this.#panel.element.isConnected) return;
      this.#panel.retime();
      if (this.isOn) void this.#load();
    });
    drawScale(query(this.#details, ".scale svg", SVGElement));
    for (const name of ["fast-run", "search"]) query(panel.element, `[name=${name}]`).onclick = () => this.#toggle();
  }

  /** Shows the fast runs instead of the states, or the states instead of the fast runs. */
  #toggle() {
    this.isOn = !this.isOn;
    const { element } = this.#panel;
    const hadFocus = element.contains(document.activeElement);
    element.classList.toggle("driving", this.isOn);
    if (this.isOn) this.update();
    else this.close();
    // The pressed button is hidden. The panel handles the shortcuts.
    if (hadFocus) element.focus({ preventScroll: true });
  }

  /** Follows the panel, which shows another source or another state. */
  update() {
    if (!this.isOn) return;
    if (this.#panel.source !== this.#source) void this.#load();
    else void this.#updateKnown();
  }

  close() {
    this.#player.pause();
    this.#abort.abort();
    this.#map?.remove();
    this.#map = this.#source = null;
  }

  /** Loads the runs of the selected vehicle. */
  async #load() {
    const { source, svg } = this.#panel;
    this.#abort.abort();
    this.#abort = new AbortController();
    const { signal } = this.#abort;
    this.#knownAt = -1;
    // The runs of another vehicle are shown until those of the selected one are planned.
    if (source !== this.#source) {
      this.#map?.remove();
      this.#map = null;
      this.#routes = [];
      this.#source = source;
      if (!source || !svg) return this.#draw("");
      this.#map = new FastRunMap(svg, source);
    }
    if (!source) return;
    this.#vehicle.value = this.vehicleFor(source);
    this.#draw("Planning…");
    try {
      const runs = source.truth ? await api.fastRuns(source, this.#vehicle.value, signal) : [];
      if (signal.aborted) return;
      // The runs of the mouse may have arrived first.
      const known = this.#knownAt < 0 ? [] : this.#routes.filter(({ name }) => OF_MOUSE.includes(name));
      this.#routes = [...runs.map(routeState), ...known];
      this.#draw(source.truth ? "" : "The true maze of this recording is unknown.");
      await this.#updateKnown();
    } catch (error) {
      if (signal.aborted) return;
      this.#routes = [];
      this.#draw(error instanceof TypeError ? "No response from the simulator." : `${error instanceof Error ? error.message : error}`);
    }
  }

  /** Returns the vehicle that was selected last in this tab, or that of the source. @param {api.Source} source */
  vehicleFor(source) {
    const names = [...this.#vehicle.options].map(({ value }) => value);
    const recalled = recall("vehicle") ?? "";
    return names.includes(recalled) ? recalled : source.vehicle;
  }

  /** Loads the run over the walls that the mouse knows in the shown state, one request at a time. */
  async #updateKnown() {
    const source = this.#source;
    // Without a server, there is only the run over the walls that the mouse knows in the last state.
    const index = api.isOffline() ? this.#panel.timeline.states - 1 : (this.#panel.shown?.index ?? -1);
    if (this.#isLoadingKnown || !source || index < 0 || index === this.#knownAt) return;
    const { signal } = this.#abort;
    this.#isLoadingKnown = true;
    try {
      const runs = await api.mouseFastRuns(source, this.#vehicle.value, index, signal);
      if (!signal.aborted) {
        this.#knownAt = index;
        this.#routes = [...this.#routes.filter(({ name }) => !OF_MOUSE.includes(name)), ...runs.map(routeState)];
        if (!this.#isChosen && this.#drivenOf !== source && runs.some(({ route }) => route === "driven")) {
          this.#drivenOf = source;
          this.#select("driven");
        } else if (!source.truth && !this.#current) this.#select("known-walls");
        else this.#draw();
      }
    } catch (error) {
      // The next state loads it again.
      if (!signal.aborted) console.warn(error);
    }
    await sleep(KNOWN_PAUSE);
    this.#isLoadingKnown = false;
    if (this.isOn) void this.#updateKnown();
  }

  /** Colours a route by speed. @param {RouteName} name */
  #select(name) {
    this.#selected = name;
    this.#shown.add(name);
    this.#draw();
  }

  /** @param {RouteName} name */
  #toggleRoute(name) {
    this.#isChosen = true;
    if (!this.#shown.delete(name)) this.#shown.add(name);
    this.#draw();
  }

  /** The shown route that is coloured by speed, or null. */
  get #current() {
    const shown = this.#routes.filter(({ name, trajectory }) => trajectory && this.#shown.has(name));
    return shown.find(({ name }) => name === this.#selected) ?? shown[0] ?? null;
  }

  /** Draws everything. @param {string} [message] a message instead of the reasons why there are no runs */
  #draw(message) {
    const current = this.#current;
    const others = this.#routes.filter((route) => route !== current && this.#shown.has(route.name)).reverse();
    const shown = current ? [...others, current] : [];
    const runs = this.#routes.flatMap(({ trajectory }) => trajectory?.run ?? []);
    const topSpeed = Math.max(1, ...runs.map((run) => run.top_speed_mm_s));
    this.#map?.draw(shown, current, topSpeed);
    this.#player.setEnd(Math.max(0, ...shown.map(({ trajectory }) => trajectory?.run.time_s ?? 0)));
    this.#chart.draw(shown, current);
    this.#list(current);
    const reasons = [...new Set(this.#routes.filter(({ name }) => this.#shown.has(name)).map(({ error }) => error))];
    setText(this.#details, ".message", message || reasons.join(" ").trim());
    query(this.#details, ".scale").hidden = !current;
    setText(this.#details, ".scale .top", formatSpeed(topSpeed));
    this.#describe(current);
  }

  /** Lists the routes, which are a legend at the same time. @param {RouteState | null} current */
  #list(current) {
    const list = query(this.#details, ".routes");
    const fastest = this.#routes.find(({ name }) => name === "fastest")?.trajectory?.run.time_s ?? 0;
    const names = this.#routes.map(({ name }) => name).join();
    if (list.dataset.routes !== names) list.replaceChildren(...this.#routes.map(({ name }) => this.#row(name)));
    list.dataset.routes = names;
    this.#routes.forEach(({ name, trajectory, error }, i) => {
      const row = /** @type {HTMLElement} */ (list.children[i]);
      const at = OF_MOUSE.includes(name) ? ` in state ${this.#knownAt}` : "";
      setAttributes(row, { title: error || ROUTES[name][1] + at });
      setText(row, ".duration", trajectory ? `${trajectory.run.time_s.toFixed(3)} s` : "none");
      const loss = trajectory && fastest > 0 && name !== "fastest" ? 100 * (trajectory.run.time_s / fastest - 1) : null;
      setText(row, ".loss", loss === null ? "" : formatLoss(loss));
      const show = query(row, "[name=show]", HTMLInputElement);
      show.checked = trajectory !== null && this.#shown.has(name);
      show.disabled = query(row, "[name=select]", HTMLButtonElement).disabled = !trajectory;
      setAttributes(query(row, "[name=select]"), { "aria-pressed": name === current?.name });
    });
  }

  /** @param {RouteName} name */
  #row(name) {
    const row = cloneTemplate("route");
    row.dataset.route = name;
    query(row, "svg", SVGElement).classList.add(colour(name));
    setText(row, ".name", ROUTES[name][0]);
    const show = query(row, "[name=show]", HTMLInputElement);
    show.setAttribute("aria-label", `Show ${ROUTES[name][0]}`);
    show.onchange = () => this.#toggleRoute(name);
    query(row, "[name=select]").onclick = () => {
      this.#isChosen = true;
      this.#select(name);
    };
    // Otherwise, the space bar would press the button again instead of playing.
    for (const name of ["show", "select"]) {
      query(row, `[name=${name}]`).onmousedown = (event) => event.preventDefault();
    }
    return row;
  }

  /** Writes the figures of a route. @param {RouteState | null} route */
  #describe(route) {
    const facts = query(this.#details, ".facts");
    facts.hidden = !route;
    const run = route?.trajectory?.run;
    if (!route || !run) return;
    setText(this.#details, ".facts-title", ROUTES[route.name][0]);
    setText(facts, ".rest", `${run.time_s.toFixed(3)} s`);
    setText(facts, ".gate", `${run.gate_to_gate_s.toFixed(3)} s`);
    setText(facts, ".length", `${(run.length_mm / 1000).toFixed(2)} m`);
    setText(facts, ".cells", run.cell_count);
    setText(facts, ".turned", run.slalom_turns);
    setText(facts, ".fastest-speed", formatSpeed(run.top_speed_mm_s));
  }

  /** Shows the mice at a time. @param {number} time in s */
  #move(time) {
    this.#map?.move(time);
    const moment = this.#current?.trajectory?.at(time);
    setText(this.#details, ".speed-now", moment ? formatSpeed(moment.speed) : "–");
    setText(this.#details, ".acceleration-now", moment ? formatAcceleration(moment.acceleration) : "–");
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey(event) {
    if (event.key === "f") this.#toggle();
    else return this.isOn && this.#player.handleKey(event);
    return true;
  }
}

/** @param {RouteName} name */
const colour = (name) => `path${Object.keys(ROUTES).indexOf(name)}`;

/** @param {number} loss in percent */
const formatLoss = (loss) => (loss < 0.05 ? "same" : `+${loss.toFixed(1)} %`);

/** @param {api.RouteRun} run @returns {RouteState} */
function routeState({ route, timed_run: run, error }) {
  return { name: route, colour: colour(route), trajectory: run && new Trajectory(run), error: error ?? "" };
}
