// @ts-check
// The chart of the speed and the acceleration over time, above the slider. The acceleration is that of the selected run.

import { HEIGHT, drawGrid, showTicks, tickStep } from "./axis.js";
import { query, setAttributes, svgElement } from "./dom.js";

/** @typedef {import("./fast_run.js").RouteState} RouteState */

/** The maximum number of intervals between ticks of the speed. */
const MAX_INTERVALS = 3;
/** The minimum distance between the times on the axis, in pixels. */
const TICK_DISTANCE = 64;

/** Formats a speed in m/s. @param {number} speed in mm/s */
export const formatSpeed = (speed) => `${(speed / 1000).toFixed(2)} m/s`;
/** Formats an acceleration in m/s². @param {number} acceleration in mm/s² */
export const formatAcceleration = (acceleration) => `${(acceleration / 1000).toFixed(1)} m/s²`.replace(/^-/, "−").replace("−0.0", "0.0");

export class FastRunChart {
  #axis;
  #speeds;
  #accelerations;
  /** @type {RouteState | null} */
  #selected = null;
  /** The heights of the horizontal lines of both plots. @type {[number[], number[]]} */
  #rows = [[], []];

  /** @param {HTMLElement} area @param {import("./axis.js").Axis} axis @param {(time: number) => void} seek shows a time in s */
  constructor(area, axis, seek) {
    this.#axis = axis;
    this.#speeds = query(area, ".speeds");
    this.#accelerations = query(area, ".accelerations");
    axis.onChange.push(() => this.#scale());
    for (const plot of [this.#speeds, this.#accelerations]) {
      axis.listen(plot, query(area, ".tip"), (milliseconds) => seek(milliseconds / 1000), (milliseconds) => this.#describe(milliseconds));
    }
  }

  /** @param {RouteState[]} routes the last one is on top @param {RouteState | null} selected */
  draw(routes, selected) {
    this.#selected = selected;
    const runs = routes.flatMap(({ trajectory }) => trajectory?.run ?? []);
    const topSpeed = Math.max(1, ...runs.map((run) => run.top_speed_mm_s / 1000));
    const step = tickStep(topSpeed, MAX_INTERVALS);
    const top = Math.ceil(topSpeed / step) * step;
    const profile = selected?.trajectory?.profile() ?? [];
    const strongest = Math.max(1, ...profile.map(([, , acceleration]) => Math.abs(acceleration / 1000)));
    const limit = tickStep(strongest, 1);
    const speeds = Array.from({ length: top / step + 1 }, (_, i) => i * step);
    this.#rows = selected ? [speeds.map((speed) => HEIGHT - (speed / top) * HEIGHT), [0, HEIGHT / 2, HEIGHT]] : [[], []];
    const lines = routes.flatMap((route) => {
      if (!route.trajectory) return [];
      const points = route.trajectory.profile().map(([time, speed]) => `${time * 1000} ${HEIGHT - (speed / 1000 / top) * HEIGHT}`);
      const d = points.length > 0 ? `M${points.join("L")}` : "";
      return svgElement("path", { class: `${route.colour}${route === selected ? " selected" : ""}`, d });
    });
    query(this.#speeds, "g", SVGElement).replaceChildren(...lines);
    const points = profile.map(([time, , acceleration]) => `${time * 1000} ${HEIGHT / 2 - (acceleration / 1000 / limit) * (HEIGHT / 2)}`);
    const d = points.length > 0 ? `M0 ${HEIGHT / 2}L${points.join("L")}V${HEIGHT / 2}z` : "";
    const area = query(this.#accelerations, ".area", SVGElement);
    setAttributes(area, { class: `area ${selected?.colour ?? ""}`, d });
    const accelerations = [`${limit}`, "0", `−${limit}`];
    showTicks(query(this.#speeds, ".y"), "top", this.#rows[0].map((height, i) => [`${speeds[i]}`, height]));
    showTicks(query(this.#accelerations, ".y"), "top", this.#rows[1].map((height, i) => [accelerations[i], height]));
    this.#scale();
  }

  /** Scales the lines and draws the ticks of the time. */
  #scale() {
    const { last, width } = this.#axis;
    if (width === 0) return; // not shown
    const step = tickStep(last, width / TICK_DISTANCE);
    const times = Array.from({ length: this.#selected ? Math.floor(last / step) + 1 : 0 }, (_, i) => i * step);
    [this.#speeds, this.#accelerations].forEach((plot, i) => drawGrid(plot, last, this.#rows[i], times));
    showTicks(query(this.#accelerations, ".x"), "left", times.map((time) => [`${time / 1000}`, 100 * this.#axis.share(time)]));
  }

  /** Describes the speed and the acceleration at a time. Returns "" if no run is shown. @param {number} milliseconds */
  #describe(milliseconds) {
    const [time, trajectory] = [milliseconds / 1000, this.#selected?.trajectory];
    if (!trajectory) return "";
    const { speed, acceleration } = trajectory.at(time);
    const turn = trajectory.segmentAt(time)?.turn;
    return `${time.toFixed(3)} s: ${formatSpeed(speed)}, ${turn ? `turn ${turn}` : formatAcceleration(acceleration)}`;
  }
}
