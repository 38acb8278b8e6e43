// @ts-check
// The curves and the mice of fast runs on a map. The curve of the selected run is coloured by speed.

import { setAttributes } from "./dom.js";
import { PITCH } from "./state.js";

/** @typedef {import("./fast_run.js").RouteState} RouteState */

/** The colours of the speeds from zero to the greatest one, in equal steps. @type {[number, number, number][]} */
const SCALE = [
  [63, 81, 201],
  [24, 142, 190],
  [38, 166, 91],
  [222, 160, 10],
  [224, 70, 24],
  [176, 14, 60],
];
/** The number of colours with which a curve is drawn. */
const COLOURS = 20;
/** The outline of a mouse that heads north. */
const MOUSE = "M0-7.6l5.5 12.9-5.5-3.1-5.5 3.1z";

/** Returns the colour of a speed. @param {number} share of the greatest speed */
function colour(share) {
  const place = Math.min(Math.max(0, share), 1) * (SCALE.length - 1);
  const index = Math.min(Math.floor(place), SCALE.length - 2);
  const [from, to] = [SCALE[index], SCALE[index + 1]];
  return `rgb(${from.map((value, i) => Math.round(value + (to[i] - value) * (place - index))).join(" ")})`;
}

/** Returns a CSS gradient of the colours from zero to the greatest speed. */
export const speedGradient = () => `linear-gradient(90deg, ${SCALE.map(([r, g, b]) => `rgb(${r} ${g} ${b})`).join(", ")})`;

export class FastRunMap {
  #curves = element("g", "curves");
  #mice = element("g", "mice");
  /** The mouse of each route. @type {Map<RouteState, SVGElement>} */
  #marks = new Map();
  #height;

  /** @param {SVGSVGElement} svg @param {import("./state.js").Size} size */
  constructor(svg, { height }) {
    this.svg = svg;
    this.#height = height;
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
      const points = moments.map((moment) => this.#point(moment, trajectory.run.half_cell, 2));
      const curve = element("path", `curve ${route.name}`);
      setAttributes(curve, { d: `M${points.join("L")}` });
      this.#curves.append(curve);
      if (route === selected) this.#drawSpeeds(moments, points, topSpeed);
      const mouse = element("path", `fast-mouse ${route.name}`);
      setAttributes(mouse, { d: MOUSE, "data-route": route.name });
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
      if (!d) return;
      const line = element("path", "speed");
      setAttributes(line, { d, stroke: colour((i + 0.5) / COLOURS) });
      this.#curves.append(line);
    });
  }

  /** Moves the mice. @param {number} time in s */
  move(time) {
    for (const [{ trajectory }, mouse] of this.#marks) {
      if (!trajectory) continue;
      const moment = trajectory.at(time);
      const degrees = 90 - (moment.heading * 180) / Math.PI;
      const at = this.#point(moment, trajectory.run.half_cell, 3);
      setAttributes(mouse, { transform: `translate(${at}) rotate(${degrees.toFixed(2)})` });
    }
  }

  /** Converts mm to units of the drawing. @param {{ x: number, y: number }} moment @param {number} halfCell @param {number} digits */
  #point({ x, y }, halfCell, digits) {
    const scale = PITCH / 2 / halfCell;
    return `${(x * scale).toFixed(digits)} ${(this.#height * PITCH - y * scale).toFixed(digits)}`;
  }
}

/** @param {string} tag @param {string} name */
function element(tag, name) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  node.setAttribute("class", name);
  return node;
}
