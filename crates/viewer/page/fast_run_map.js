// @ts-check
// The curves and the mice of fast runs on a map. The curve of the selected run is coloured by speed.

import { setAttributes, svgElement } from "./dom.js";
import { PITCH } from "./state.js";

/** @typedef {import("./fast_run.js").RouteState} RouteState */

/** The number of colours of the speeds from zero to the greatest one. Their classes are `speed0`, `speed1` and so on. */
const COLOURS = 24;
/** In mazes with more cells than this on a side, mice and curves are drawn larger, by at most this factor. */
const [SIDE, MAX_SCALE] = [16, 1.6];

/** Draws the colours from zero to the greatest speed. @param {SVGElement} scale an SVG that is as wide as there are colours */
export function drawScale(scale) {
  const colours = Array.from({ length: COLOURS }, (_, i) => svgElement("path", { class: `speed${i}`, d: `M${i} .5h1` }));
  setAttributes(scale, { viewBox: `0 0 ${COLOURS} 1` });
  scale.replaceChildren(...colours);
}

export class FastRunMap {
  #curves = svgElement("g", { class: "curves" });
  #mice = svgElement("g", { class: "mice" });
  /** The mouse of each route. @type {Map<RouteState, SVGElement>} */
  #marks = new Map();
  #height;
  /** The outline of a mouse that heads north. */
  #outline;

  /** @param {SVGSVGElement} svg @param {import("./state.js").Size} size */
  constructor(svg, { width, height }) {
    this.#height = height;
    const scale = Math.min(Math.max(1, Math.max(width, height) / SIDE), MAX_SCALE);
    const [x, y, notch] = [5.5 * scale, 7.6 * scale, 2.2 * scale];
    this.#outline = `M0 ${-y}L${x} ${0.7 * y} 0 ${notch} ${-x} ${0.7 * y}z`;
    this.#curves.style.setProperty("--scale", `${scale}`);
    svg.append(this.#curves, this.#mice);
  }

  remove() {
    this.#curves.remove();
    this.#mice.remove();
  }

  /**
   * Draws the curves and makes the mice.
   * @param {RouteState[]} routes the last one is on top
   * @param {RouteState | null} selected the run that is coloured by speed
   * @param {number} topSpeed the speed at the end of the scale
   */
  draw(routes, selected, topSpeed) {
    this.#curves.replaceChildren();
    this.#mice.replaceChildren();
    this.#marks.clear();
    for (const route of routes) {
      const { trajectory } = route;
      if (!trajectory) continue;
      const moments = trajectory.outline();
      const points = moments.map((moment) => this.#point(moment, trajectory.run.half_cell_mm, 2));
      this.#curves.append(svgElement("path", { class: `curve ${route.name} ${route.colour}`, d: `M${points.join("L")}` }));
      if (route === selected) this.#drawSpeeds(moments, points, topSpeed);
      const mouse = svgElement("path", { class: `fast-mouse ${route.colour}`, d: this.#outline, "data-route": route.name });
      this.#mice.append(mouse);
      this.#marks.set(route, mouse);
    }
  }

  /** @param {import("./trajectory.js").Moment[]} moments @param {string[]} points @param {number} topSpeed */
  #drawSpeeds(moments, points, topSpeed) {
    const lines = Array.from({ length: COLOURS }, () => "");
    let last = -1;
    for (let i = 1; i < points.length; i++) {
      const share = (moments[i - 1].speed + moments[i].speed) / 2 / topSpeed;
      const index = Math.min(Math.floor(share * COLOURS), COLOURS - 1);
      lines[index] += index === last ? `L${points[i]}` : `M${points[i - 1]}L${points[i]}`;
      last = index;
    }
    lines.forEach((d, i) => {
      if (d) this.#curves.append(svgElement("path", { class: `speed speed${i}`, d }));
    });
  }

  /** Moves the mice. @param {number} time in s */
  move(time) {
    for (const [{ trajectory }, mouse] of this.#marks) {
      if (!trajectory) continue;
      const moment = trajectory.at(time);
      const degrees = 90 - (moment.heading * 180) / Math.PI;
      const at = this.#point(moment, trajectory.run.half_cell_mm, 3);
      setAttributes(mouse, { transform: `translate(${at}) rotate(${degrees.toFixed(2)})` });
    }
  }

  /** Converts mm to units of the drawing. @param {{ x: number, y: number }} moment @param {number} halfCell @param {number} digits */
  #point({ x, y }, halfCell, digits) {
    const scale = PITCH / 2 / halfCell;
    return `${(x * scale).toFixed(digits)} ${(this.#height * PITCH - y * scale).toFixed(digits)}`;
  }
}
