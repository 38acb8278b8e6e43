// @ts-check
// A panel shows a source of states, which is either the live simulation or a recording. The panel contains the map,
// the player controls and the figures of the shown state.

import * as api from "./api.js";
import { cloneTemplate, nextFrame, oneAtATime, query, recall, remember, setAttributes, setText, showError, sleep } from "./dom.js";
import { drawFactor } from "./events.js";
import { FastRun } from "./fast_run.js";
import { announce, showFigures, showResult } from "./figures.js";
import { LogPane } from "./log.js";
import { MazeMap, describeCell } from "./map.js";
import { Overview } from "./overview.js";
import { DX, DY, decodeState } from "./state.js";
import { Timeline } from "./timeline.js";
import { Viewport } from "./viewport.js";

/** Minimum time between two draws of a running search in a single window, in ms, to leave the processors to the search. */
const DRAW_INTERVAL = 100;
/** Minimum time between loads of the source, in milliseconds. Clients may reset more often. */
const LOAD_PAUSE = 100;
/** Minimum time between updates of the chart in a single window, in ms. A state is announced once it has been shown for at least this long. */
const SLOW_INTERVAL = 1000;
/** The result of a run of up to this many states is shown. */
const MAX_RESULT_STATES = 20_000;
/** After the page has loaded a whole run, it waits this many times as long before it loads the run again. */
const KEEP_PAUSE = 9;

/** The names of the layers that the server can draw too. */
const LAYERS = ["numbers", "heat", "trail", "texts", "colours", "shortest", "plan"];

export class Panel {
  /** Shown while the live simulation has no states. */
  hint = "Press Run, or connect a mouse.";
  element = cloneTemplate("panel");
  /** Called when the panel shows another state, or the same state in another way. */
  onShow = () => {};
  id;
  #style;
  #overview;
  #viewport;
  #log;
  #fastRun;
  #abort = new AbortController();
  #loading = false;
  /** The live run in the last event. @type {{ run: number, states: number, annotations: number } | null} */
  #latest = null;
  /** The loaded source, or null. @type {api.Source | null} */
  source = null;
  /** @type {MazeMap | null} */
  #map = null;
  /** The shown state, or null. @type {import("./figures.js").Shown | null} */
  shown = null;
  #drawing = false;
  /** True if another vehicle must time the shown state. */
  #mustRetime = false;
  /** When the next live state may be drawn. */
  #nextDraw = 0;
  /** Ends the pause before the next draw. */
  #endPause = () => {};
  /** The state to show once its run is loaded. @type {{ run: number, index: number } | null} */
  #start = null;
  #slowTimer = 0;
  /** When the chart of a running search may be updated. */
  #nextChart = 0;
  /** Index of the state that was shown at the end of the previous slow interval. */
  #settled = -1;
  /** Index of the state that was announced last. */
  #announced = -1;
  /** The highlighted cell, y * width + x. @type {number | null} */
  #cell = null;
  /** Index of the state that shows why the mouse failed, or -1. */
  #failedAt = -1;
  /** The size of the maze, such as `16 × 16`. */
  #size = "";

  /** @param {string} id @param {api.DrawingStyle} style @param {api.PageInfo} info */
  constructor(id, style, info) {
    const { element } = this;
    this.id = id;
    this.#style = style;
    element.dataset.source = id;
    this.timeline = new Timeline(element, id === "live", () => void this.#draw());
    this.#overview = new Overview(element, this.timeline);
    this.#viewport = new Viewport(element, style);
    this.#log = new LogPane(element, (index) => this.timeline.seek(index));
    this.#fastRun = new FastRun(this, info);
    // The details of a recording contain no controls, but they may have to be scrolled.
    if (id !== "live") query(element, ".details").tabIndex = 0;
    showLegend(element);
    query(element, ".layers").onchange = () => this.#show();
    for (const event of ["pointerdown", "keydown"]) {
      query(element, ".export").addEventListener(event, () => this.#updateExportLinks());
    }
    const map = query(element, ".map");
    map.onpointermove = (event) => this.#highlight(this.#map?.cellAt(event) ?? null);
    map.onpointerleave = map.onblur = () => this.#highlight(null);
    // A click does not focus the map, so the arrow keys still step through the history after a click.
    map.onmousedown = (event) => event.preventDefault();
    map.onkeydown = (event) => this.#handleMapKey(event);
  }

  /** Updates the live panel after an event. @param {number} run @param {number} states @param {number} annotations */
  follow(run, states, annotations) {
    this.#latest = { run, states, annotations };
    if (this.#hasNewRun) return void this.load();
    if (this.source?.run === run) this.timeline.grow(states);
    if (this.shown) this.#showSlowly(); // also draws new states in the chart while an earlier state is shown
    void this.#draw(); // also retries a draw that failed while the connection was lost
  }

  /** Requests the shown state again, with the times of another vehicle. */
  retime() {
    this.#mustRetime = true;
    void this.#draw();
  }

  /** True if the vehicle has changed, or the mouse has annotated the last state, after it was shown. */
  get #isOutdated() {
    if (this.#mustRetime) return true;
    const { shown } = this;
    const isLast = shown !== null && shown.index === this.timeline.states - 1;
    return isLast && (shown.view.annotations ?? 0) < (this.#latest?.annotations ?? 0);
  }

  /** The drawing of the maze, or null. */
  get svg() {
    return this.#map?.svg ?? null;
  }

  /** True if a newer run has started. Run numbers increase. */
  get #hasNewRun() {
    return this.#latest !== null && this.#latest.run > (this.source?.run ?? -1);
  }

  /** Loads the source and replaces the content of the panel. */
  async load() {
    if (this.#loading) return;
    this.#loading = true;
    this.source = null;
    this.#abort.abort();
    this.#abort = new AbortController();
    const { signal } = this.#abort;
    let retry = true;
    try {
      const source = await api.source(this.id, signal);
      this.#install(source, await api.drawing(source, signal));
    } catch (error) {
      retry = api.isRunOver(error);
      if (!retry) showError(error); // the next event loads the source again
    }
    await sleep(LOAD_PAUSE);
    this.#loading = false;
    if (retry && this.#hasNewRun) void this.load();
  }

  /** @param {api.Source} source @param {string} drawing */
  #install(source, drawing) {
    const { element } = this;
    const kind = this.id === "live" ? "live" : "recording";
    const isSameSize = this.#size === `${source.width} × ${source.height}`;
    this.source = source;
    this.#size = `${source.width} × ${source.height}`;
    this.shown = null;
    this.#settled = this.#announced = this.#failedAt = -1;
    this.#overview.clear();
    this.#map = new MazeMap(drawing, source, this.#style);
    this.#viewport.install(this.#map.svg, source);
    query(element, ".map").style.setProperty("--ratio", `${source.width / source.height}`);
    element.dataset.run = `${source.run}`;
    delete element.dataset.kept;
    element.setAttribute("aria-label", `${source.title}, ${kind}`);
    setText(element, "h2", source.title).title = source.title;
    setText(element, ".kind", kind);
    setText(element, ".size", this.#size);
    setText(element, ".note", source.note ?? "").title = source.note ?? "";
    setText(element, ".about-maze", kind === "recording" ? `maze ${source.maze}` : "");
    setText(element, ".about-mouse", "");
    this.#offer("texts", false);
    this.#offer("colours", false);
    this.#offer("shortest", source.truth);
    this.#log.clear();
    clearTimeout(this.#slowTimer);
    this.#slowTimer = 0;
    // An event may have reported more states during loading.
    const states = this.#latest?.run === source.run ? this.#latest.states : 0;
    this.timeline.start(Math.max(source.states, states));
    if (this.#start?.run === source.run) this.timeline.moveLinked(this.#start.index);
    this.#start = null;
    // The pointer may still be on the highlighted cell.
    this.#highlight(isSameSize ? this.#cell : null);
    this.#show();
  }

  /** Shows a state of a run as soon as the run is loaded. Linked panels do not move. @param {number} run @param {number} index */
  showState(run, index) {
    if (this.source?.run === run) this.timeline.moveLinked(index);
    else this.#start = { run, index };
  }

  close() {
    this.source = null;
    this.#fastRun.close();
    this.timeline.seek(0);
    this.#abort.abort();
    this.element.remove();
  }

  /** Draws until the target state is shown. If the target changes during a draw, the states in between are skipped. */
  async #draw() {
    if (this.#drawing) {
      if (!this.timeline.following) this.#endPause();
      return;
    }
    this.#drawing = true;
    /** @type {api.Source | null} */
    let source = null;
    try {
      for (;;) {
        const pause = this.#nextDraw - performance.now();
        if (this.timeline.following && pause > 0) {
          await Promise.race([sleep(pause), new Promise((resolve) => (this.#endPause = () => resolve(null)))]);
        }
        const { signal } = this.#abort;
        source = this.source;
        const index = this.timeline.target;
        if (!source || index < 0 || (index === this.shown?.index && !this.#isOutdated)) break;
        this.#mustRetime = false;
        const view = await api.stateView(source, index, signal, this.#fastRun.vehicleFor(source));
        if (source !== this.source) continue;
        this.timeline.grow(view.states);
        this.#nextDraw = performance.now() + DRAW_INTERVAL * drawFactor();
        this.shown = { index, state: decodeState(Uint8Array.from(view.state), source), view };
        this.#show();
        await nextFrame();
      }
    } catch (error) {
      if (!api.isRunOver(error)) showError(error);
      else if (source === this.source && this.#latest) void this.load();
    }
    this.#drawing = false;
  }

  #show() {
    const shown = this.shown;
    const layers = this.#layers;
    if (shown) {
      this.#map?.show(shown.state, shown.view, layers);
      this.#showAnnotations(shown.view);
      if (this.#log.isShown) this.#showLog();
    }
    this.timeline.show();
    showFigures(this.element, this.source, shown?.view);
    if (!this.#isAtEnd) {
      // The state that shows why the mouse failed has only the first line of the result, which says so.
      query(this.element, ".outcome").hidden = shown?.index !== this.#failedAt;
      query(this.element, ".outcome").classList.add("at-failure");
    }
    this.#showCell();
    setAttributes(this.element, { "data-index": shown?.index ?? "" });
    this.#showSlowly();
    this.#fastRun.update();
    this.onShow();
  }

  get #layers() {
    const checked = LAYERS.map((name) => [name, query(this.element, `[name=${name}]`, HTMLInputElement).checked]);
    return /** @type {import("./map.js").Layers} */ (Object.fromEntries(checked));
  }

  /** Shows the names of the mouse and its strategy, and the layers that the mouse uses. @param {api.StateView} view */
  #showAnnotations({ mouse, strategy, trial, texts, colours, plan }) {
    const names = trial ? [] : [mouse, strategy].filter(Boolean);
    setText(this.element, ".about-mouse", names.join(" · "));
    if (texts.length > 0) this.#offer("texts", true);
    if (colours) this.#offer("colours", true);
    const title = "The path along which the weights lead: always to the neighbour with the lowest weight, around known walls";
    const none = plan.length > 0 ? "" : ". None in this state: no reachable neighbour has a lower weight";
    setAttributes(query(this.element, ".plan-layer"), { title: title + none });
  }

  /** Shows or hides a layer that is not always available, and its legend. @param {"texts" | "colours" | "shortest"} layer @param {boolean} offered */
  #offer(layer, offered) {
    this.element.classList.toggle(`has-${layer}`, offered);
    for (const part of this.element.querySelectorAll(`.${layer}-layer`)) part.toggleAttribute("hidden", !offered);
  }

  #showLog() {
    const [source, shown] = [this.source, this.shown];
    const annotations = this.#latest?.annotations ?? 0;
    if (source && shown) this.#log.show(source, shown.index, this.timeline.states, annotations, this.#abort.signal);
  }

  /** Updates the chart, the export links and the announcement. These updates need not follow each state. */
  #showSlowly() {
    this.#slowTimer ||= setTimeout(
      async () => {
        this.#slowTimer = 0;
        const [source, index, { states }] = [this.source, this.shown?.index ?? -1, this.timeline];
        if (!source) return;
        if (index !== this.#settled && performance.now() < this.#nextChart) {
          this.#settled = index;
          return this.#showSlowly();
        }
        this.#nextChart = performance.now() + SLOW_INTERVAL * (drawFactor() - 1);
        this.#updateExportLinks();
        this.#showLog(); // the lines of an earlier state may have arrived since
        const isTrial = source.mouse !== null || this.shown?.view.trial != null;
        if (!(await this.#overview.update(source, states, isTrial, this.#abort.signal))) return;
        if (source !== this.source) return;
        const isSettled = this.#settled === index && index === (this.shown?.index ?? -1);
        if (isSettled && this.#announced !== index) announce(this.element, this.shown, this.#overview.marks.describe(index));
        if (isSettled) this.#announced = index;
        this.#settled = index;
        if (isSettled) {
          void this.#keep();
          void this.#showResult();
        }
        // A hidden window receives the next event once it is visible.
        if (!isSettled || (states !== this.timeline.states && !document.hidden)) this.#showSlowly();
      },
      this.#overview.isEmpty ? 0 : SLOW_INTERVAL,
    );
  }

  /** Keeps the run, so that the panel can show it when the server has stopped. */
  #keep = oneAtATime(async () => {
    const started = performance.now();
    const { source, timeline } = this;
    // A server that is busy may send the run later.
    const states = source && (await api.keep(source, timeline.states, this.#fastRun.vehicleFor(source), this.#abort.signal).catch(() => null));
    if (states && source === this.source) setAttributes(this.element, { "data-kept": states });
    await sleep(KEEP_PAUSE * (performance.now() - started));
  });

  get #isAtEnd() {
    return this.shown !== null && this.shown.index === this.timeline.states - 1;
  }

  /**
   * Shows what the mouse has achieved, in the last state. If the mouse has failed, moves to the state that shows why,
   * unless the user has chosen the shown state.
   */
  async #showResult() {
    const { source, shown } = this;
    if (!source || !shown || !this.#isAtEnd || shown.view.trial || this.timeline.states > MAX_RESULT_STATES) return;
    const result = await api.result(source, this.#fastRun.vehicleFor(source), this.#abort.signal).catch(api.showUnlessOver);
    if (!result || shown !== this.shown) return;
    showResult(this.element, result, shown.view, (index) => this.timeline.seek(index));
    query(this.element, ".outcome").hidden = false;
    query(this.element, ".outcome").classList.remove("at-failure");
    this.#failedAt = result.cause?.state ?? -1;
    const { following, isChosen } = this.timeline;
    const isElsewhere = this.#failedAt >= 0 && this.#failedAt !== shown.index;
    if (isElsewhere && following && !isChosen) this.timeline.moveLinked(this.#failedAt);
  }

  /** Makes the export links save the shown state, layers and theme. */
  #updateExportLinks() {
    if (!this.source) return;
    const theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    const options = { ...this.#layers, theme };
    const vehicle = this.#fastRun.vehicleFor(this.source);
    for (const link of this.element.querySelectorAll("a[download]")) {
      const resource = link.getAttribute("data-export") ?? "";
      const parameters = { "recording.mcap": {}, "page.html": { vehicle }, "animation.gif": options }[resource] ?? { at: this.shown?.index, ...options };
      if (this.shown) setAttributes(link, { href: api.sourceUrl(this.source, resource, parameters) });
      else link.removeAttribute("href");
      link.ariaDisabled = `${!this.shown}`;
    }
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey(event) {
    if (this.#fastRun.handleKey(event)) return true;
    const hasStates = !this.#fastRun.isOn && api.isShowable(this.source);
    return (hasStates && (this.timeline.handleKey(event) || this.#overview.marks.handleKey(event))) || this.#viewport.handleKey(event);
  }

  /** Moves the highlight with the arrow keys. The first move starts at the mouse. @param {KeyboardEvent} event */
  #handleMapKey(event) {
    const source = this.source;
    const heading = ["ArrowUp", "ArrowRight", "ArrowDown", "ArrowLeft"].indexOf(event.key);
    if (heading < 0 || !source) return;
    event.preventDefault();
    const { width, height, start } = source;
    const [mouseX, mouseY] = this.shown ? [this.shown.state.x, this.shown.state.y] : start;
    const from = this.#cell ?? mouseY * width + mouseX;
    const [x, y] = [(from % width) + DX[heading], Math.floor(from / width) + DY[heading]];
    if (x < 0 || y < 0 || x >= width || y >= height) return;
    this.#highlight(y * width + x);
    this.#viewport.reveal(y * width + x);
  }

  /** @param {number | null} cell */
  #highlight(cell) {
    this.#cell = cell;
    this.#map?.highlight(cell);
    this.#showCell();
  }

  #showCell() {
    const source = this.source;
    const waiting = this.id === "live" && this.timeline.states === 0;
    const hint = waiting && !this.source?.mouse ? this.hint : "";
    const cell = this.#cell;
    const shown = this.shown;
    const text = source && cell !== null ? describeCell(cell, source, shown?.state, shown?.view, this.#style) : hint;
    setText(this.element, ".readout", text);
  }
}

/** Shows the legend if it was shown last in this tab, and lets the user show and hide it. @param {HTMLElement} panel */
function showLegend(panel) {
  const button = query(panel, "[name=legend]", HTMLButtonElement);
  const legend = query(panel, ".legend");
  /** @param {boolean} shown */
  const show = (shown) => {
    legend.hidden = !shown;
    button.ariaExpanded = `${shown}`;
    remember("legend", shown ? "shown" : "");
  };
  show(recall("legend") === "shown");
  button.onclick = () => show(legend.hidden);
}
