// @ts-check
// A panel shows one source of states, the live simulation or a recording: its map, its history and the
// figures of the shown state.

import * as api from "./api.js";
import { Chart } from "./chart.js";
import { copy, frame, part, pause, report, set, write } from "./dom.js";
import { showFigures, tell } from "./figures.js";
import { MazeMap, dark, describeCell } from "./map.js";
import { DX, DY, readState } from "./state.js";
import { Timeline } from "./timeline.js";

/**
 * Milliseconds between draws of live states: every other frame of a usual screen, and longer where
 * drawing is slow, so many times as long as a draw takes. States that rush past come from a search at
 * full speed, which is left the processors.
 */
const REST = { least: 25, most: 150, calm: 2, rush: 10 };
/** States between two draws that are too many for numbers to be read, which are half the work of one. */
const RUSH = 50;
/** Milliseconds without a draw until numbers come back. */
const CALM = 100;
/** Milliseconds between runs: a client may reset as often as it likes. */
const BEGIN_PAUSE = 100;
/** Milliseconds between looks at the costs, and until a state that stays is told in words. */
const SLOW = 1000;

/** @param {unknown} problem */
const isOver = (problem) => problem instanceof api.Refused && problem.over;

export class Panel {
  element = copy("panel");
  #id;
  #drawing;
  #chart;
  #abort = new AbortController();
  #beginning = false;
  /** What the server told last of the live run. @type {{ run: number, states: number } | null} */
  #news = null;
  /** @type {api.Source | null} */
  #source = null;
  /** @type {MazeMap | null} */
  #map = null;
  /** @type {import("./figures.js").Shown | null} */
  #shown = null;
  #busy = false;
  /** When the next live state may be drawn. */
  #rest = 0;
  /** Ends the rest, since another state than the newest is wanted. */
  #wake = () => {};
  /** Whether more states pass between two draws than an eye could follow. */
  #rushes = false;
  #calmTimer = 0;
  #slowTimer = 0;
  #told = -1;
  #costsOf = -1;
  /** The cell that is pointed at, y * width + x. @type {number | null} */
  #cell = null;
  #redraw = () => this.#show();

  /** @param {string} id @param {api.Drawing} drawing */
  constructor(id, drawing) {
    const { element } = this;
    this.#id = id;
    this.#drawing = drawing;
    element.dataset.source = id;
    this.timeline = new Timeline(element, id === "live", () => void this.#draw());
    this.#chart = new Chart(element, (at) => this.timeline.go(at));
    part(element, ".layers").onchange = () => this.#show();
    dark.addEventListener("change", this.#redraw);
    for (const event of ["pointerdown", "keydown"]) {
      part(element, ".export").addEventListener(event, () => this.#address());
    }
    const map = part(element, ".map");
    map.onpointermove = (event) => this.#point(this.#map?.cellAt(event) ?? null);
    map.onpointerleave = map.onblur = () => this.#point(null);
    map.onmousedown = (event) => event.preventDefault(); // arrow keys stay with the history after a click
    map.onkeydown = (event) => this.#press(event);
  }

  /** What the server tells of the live run. @param {number} run @param {number} states */
  follow(run, states) {
    this.#news = { run, states };
    if (this.#isBehind) return void this.begin();
    if (this.#source?.run === run) this.timeline.grow(states);
    void this.#draw(); // what could not be had while the connection was lost
  }

  /** Whether the server has told of a later run than this one: runs are counted upwards. */
  get #isBehind() {
    return this.#news !== null && this.#news.run > (this.#source?.run ?? -1);
  }

  /** Empties the panel and shows the source as it is now. */
  async begin() {
    if (this.#beginning) return;
    this.#beginning = true;
    this.#source = null;
    this.#abort.abort();
    this.#abort = new AbortController();
    const { signal } = this.#abort;
    let again = true;
    try {
      const source = await api.source(this.#id, signal);
      this.#install(source, await api.drawing(source, signal));
    } catch (problem) {
      again = isOver(problem);
      if (!again) report(problem); // and the server's next word begins anew
    }
    await pause(BEGIN_PAUSE);
    this.#beginning = false;
    if (again && this.#isBehind) void this.begin();
  }

  /** @param {api.Source} source @param {string} drawing */
  #install(source, drawing) {
    const { element } = this;
    const kind = this.#id === "live" ? "live" : "recording";
    this.#source = source;
    this.#shown = null;
    this.#costsOf = this.#told = -1;
    this.#map = new MazeMap(drawing, source, this.#drawing);
    part(element, ".map").replaceChildren(this.#map.svg);
    part(element, ".map").style.setProperty("--ratio", `${source.width / source.height}`);
    element.dataset.run = `${source.run}`;
    element.setAttribute("aria-label", `${source.title}, ${kind}`);
    write(element, "h2", source.title);
    part(element, "h2").title = source.title;
    write(element, ".kind", kind);
    write(element, ".size", `${source.width} × ${source.height}`);
    write(element, ".note", source.note ?? "");
    clearTimeout(this.#slowTimer);
    this.#slowTimer = 0;
    // More may have been told of while all this was fetched.
    const told = this.#news?.run === source.run ? this.#news.states : 0;
    this.timeline.begin(Math.max(source.states, told));
    this.#point(null);
    this.#show();
  }

  close() {
    this.#source = null;
    this.timeline.go(0);
    this.#abort.abort();
    dark.removeEventListener("change", this.#redraw);
    this.element.remove();
  }

  /** Draws the wanted state, then the one that is wanted by then, until none is: never a queue. */
  async #draw() {
    if (this.#busy) {
      if (!this.timeline.following) this.#wake();
      return;
    }
    this.#busy = true;
    clearTimeout(this.#calmTimer);
    /** @type {api.Source | null} */
    let source = null;
    try {
      for (;;) {
        const rest = this.#rest - performance.now();
        if (this.timeline.following && rest > 0) {
          await Promise.race([pause(rest), new Promise((wake) => (this.#wake = () => wake(null)))]);
        }
        const { signal } = this.#abort;
        source = this.#source;
        const at = this.timeline.wanted;
        if (!source || at < 0 || at === this.#shown?.at) break;
        const moment = await api.moment(source, at, signal);
        if (source !== this.#source) continue;
        this.timeline.grow(moment.states);
        const began = performance.now();
        this.#rushes = this.timeline.following && at - (this.#shown?.at ?? at) > RUSH;
        this.#shown = { at, state: readState(Uint8Array.from(moment.state), source), moment };
        this.#show();
        const shown = performance.now();
        await frame(); // at most one draw a frame
        const painting = performance.now();
        await pause(0); // until it is painted
        const now = performance.now();
        const { least, most, calm, rush } = REST;
        const share = this.#rushes ? rush : calm;
        this.#rest = now + Math.min(Math.max(least, share * (shown - began + now - painting)), most);
      }
    } catch (problem) {
      if (!isOver(problem)) report(problem);
      else if (source === this.#source && this.#news) void this.begin();
    }
    this.#busy = false;
    this.#calmTimer = setTimeout(() => {
      if (!this.#rushes) return;
      this.#rushes = false;
      this.#show();
    }, CALM);
  }

  #show() {
    const shown = this.#shown;
    const layers = this.#layers;
    layers.numbers &&= !this.#rushes;
    if (shown) this.#map?.show(shown.state, shown.moment.trail, layers);
    this.timeline.show();
    this.#chart.show(shown?.at ?? 0);
    showFigures(this.element, this.#source, shown?.moment);
    this.#showCell();
    set(this.element, "data-at", shown?.at ?? "");
    set(this.element, "data-rush", this.#rushes);
    this.#showSlowly();
  }

  get #layers() {
    /** @param {string} name */
    const checked = (name) => part(this.element, `[name=${name}]`, HTMLInputElement).checked;
    return { numbers: checked("numbers"), heat: checked("heat"), trail: checked("trail") };
  }

  /** Shows what need not be told at once: costs over the run, addresses of exports, the state in words. */
  #showSlowly() {
    this.#slowTimer ||= setTimeout(
      async () => {
        this.#slowTimer = 0;
        const [source, at, { states }] = [this.#source, this.#shown?.at ?? -1, this.timeline];
        if (!source) return;
        this.#address();
        if (this.#costsOf !== states) {
          const costs = await api.costs(source, this.#abort.signal).catch(() => null);
          if (!costs) return;
          const newest = costs.stride > 1 && api.moment(source, costs.states - 1, this.#abort.signal).catch(() => null);
          const moment = (await newest) || null;
          if (source !== this.#source) return;
          this.#costsOf = states;
          this.#chart.draw(costs, moment);
          this.#chart.show(this.#shown?.at ?? 0);
        }
        if (this.#told === at) return tell(this.element, this.#shown);
        this.#told = at;
        this.#showSlowly();
      },
      this.#costsOf < 0 ? 0 : SLOW,
    );
  }

  /** Puts what is shown into the addresses of exports. */
  #address() {
    if (!this.#source) return;
    const layers = Object.entries(this.#layers).map(([layer, shown]) => `&${layer}=${shown}`);
    const look = `${layers.join("")}&theme=${dark.matches ? "dark" : "light"}`;
    for (const link of this.element.querySelectorAll("a[download]")) {
      const what = link.getAttribute("data-export") ?? "";
      const query = { "recording.mcap": "", "animation.gif": look }[what] ?? `&at=${this.#shown?.at}${look}`;
      if (this.#shown) set(link, "href", api.sourceAddress(this.#source, what, query));
      else link.removeAttribute("href");
    }
  }

  /** Arrow keys go from cell to cell, at first from the mouse's. @param {KeyboardEvent} event */
  #press(event) {
    const source = this.#source;
    const heading = ["ArrowUp", "ArrowRight", "ArrowDown", "ArrowLeft"].indexOf(event.key);
    if (heading < 0 || !source) return;
    event.preventDefault();
    const { width, height, start } = source;
    const [column, row] = this.#shown ? [this.#shown.state.x, this.#shown.state.y] : start;
    const from = this.#cell ?? row * width + column;
    const [x, y] = [(from % width) + DX[heading], Math.floor(from / width) + DY[heading]];
    if (x >= 0 && y >= 0 && x < width && y < height) this.#point(y * width + x);
  }

  /** @param {number | null} cell */
  #point(cell) {
    this.#cell = cell;
    this.#map?.mark(cell);
    this.#showCell();
  }

  #showCell() {
    const source = this.#source;
    const waiting = this.#id === "live" && this.timeline.states === 0;
    const hint = waiting ? "Press Run, or connect a mouse of yours." : "";
    const cell = this.#cell;
    write(this.element, ".readout", source && cell !== null ? describeCell(cell, source, this.#shown?.state) : hint);
  }
}
