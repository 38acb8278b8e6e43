// @ts-check
// The map of the maze, which is an SVG drawn by the server. For each state, the page updates only the elements that
// change, since most of the thousands of elements stay the same.

import { setAttributes } from "./dom.js";
import { DX, DY, HEADINGS, VISITED, WALL_BITS } from "./state.js";

/**
 * @typedef {import("./api.js").DrawingStyle} DrawingStyle
 * @typedef {import("./api.js").Source} Source
 * @typedef {import("./state.js").State} State
 * @typedef {Record<"numbers" | "heat" | "trail", boolean>} Layers
 */

const PITCH = 20;
export const dark = matchMedia("(prefers-color-scheme: dark)");

/** An attribute of many elements. Its value depends on a number per element, and is written when that number changes. */
class Attributes {
  /** @param {Element[]} elements @param {string} name @param {(value: number, index: number) => string} format */
  constructor(elements, name, format) {
    this.elements = elements;
    this.name = name;
    this.format = format;
    // -2 is not a valid number, so the first state writes all attributes.
    this.values = new Int16Array(elements.length).fill(-2);
  }

  /** @param {number} index @param {number} value */
  set(index, value) {
    if (this.values[index] === value) return;
    this.values[index] = value;
    this.elements[index].setAttribute(this.name, this.format(value, index));
  }
}

export class MazeMap {
  #source;
  #cells;
  #walls;
  #wallSides;
  #numbers;
  #heat;
  #trail;
  #trailPoints = "";
  #mouse;
  #cursor = document.createElementNS("http://www.w3.org/2000/svg", "rect");

  /** @param {string} drawing @param {Source} source @param {DrawingStyle} style */
  constructor(drawing, source, style) {
    const parsed = new DOMParser().parseFromString(drawing, "image/svg+xml").documentElement;
    const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.adoptNode(parsed)));
    const { width, height } = source;
    /** @param {string} selector */
    const all = (selector) => [...svg.querySelectorAll(selector)];
    this.#source = source;
    this.svg = svg;
    this.#trail = all(".trail")[0];
    this.#mouse = all(".mouse")[0];

    const cells = all(".cell");
    const classes = cells.map((cell) => (cell.getAttribute("class") ?? "").replace(" visited", ""));
    this.#cells = new Attributes(cells, "class", (visited, i) => classes[i] + (visited ? " visited" : ""));

    const walls = all(".wall");
    const isTrue = walls.map((wall) => wall.classList.contains("true"));
    this.#walls = new Attributes(walls, "class", (reported, i) => {
      const wall = isTrue[i] ? "wall true" : "wall";
      return !reported ? wall : isTrue[i] || !source.truth ? `${wall} known` : "wall mistaken";
    });
    /** The two cells next to each wall, and the bit of the wall in each cell. Either cell may report the wall. */
    this.#wallSides = walls.map((wall) => {
      const [x, y, side] = (wall.getAttribute("data-wall") ?? "").split(",");
      const heading = "NESW".indexOf(side);
      const [otherX, otherY] = [Number(x) + DX[heading], Number(y) + DY[heading]];
      const outer = otherX < 0 || otherY < 0 || otherX >= width || otherY >= height;
      const [bit, otherBit] = [WALL_BITS[heading], WALL_BITS[(heading + 2) % 4]];
      return { outer, cell: Number(y) * width + Number(x), bit, other: otherY * width + otherX, otherBit };
    });

    /** @type {string[]} */
    const paths = [];
    this.#numbers = new Attributes(all(".number"), "d", (number) => (paths[number] ??= numberPath(number, style)));
    const colours = [...style.heat.light, ...style.heat.dark];
    this.#heat = new Attributes(all(".heat"), "fill", (colour) => (colour < 0 ? "none" : colours[colour]));

    setAttributes(this.#cursor, { class: "cursor", width: PITCH, height: PITCH });
    this.#showWalls(new Uint8Array(cells.length));
    this.#placeMouse(source.start[0], source.start[1], 0);
  }

  /** @param {State} state @param {number[]} trail cells, oldest first @param {Layers} layers */
  show(state, trail, layers) {
    for (const [layer, shown] of Object.entries(layers)) this.svg.classList.toggle(`hide-${layer}`, !shown);
    this.#showWalls(state.walls);
    // A hidden layer is updated when it is shown again.
    this.#showWeights(state.weights, layers);
    if (layers.trail) this.#showTrail(trail);
    this.#placeMouse(state.x, state.y, state.heading);
  }

  /** @param {Uint8Array} walls */
  #showWalls(walls) {
    for (let i = 0; i < walls.length; i++) this.#cells.set(i, walls[i] & VISITED);
    for (let i = 0; i < this.#wallSides.length; i++) {
      const { outer, cell, bit, other, otherBit } = this.#wallSides[i];
      this.#walls.set(i, outer || walls[cell] & bit || walls[other] & otherBit ? 1 : 0);
    }
  }

  /** @param {Uint8Array} weights @param {Layers} layers */
  #showWeights(weights, { numbers, heat }) {
    const max = Math.max(...weights);
    const first = dark.matches ? 64 : 0;
    for (let i = 0; i < weights.length; i++) {
      if (numbers) this.#numbers.set(i, max > 0 ? weights[i] : -1);
      if (heat) this.#heat.set(i, max > 0 ? first + Math.round((weights[i] * 63) / max) : -1);
    }
  }

  /** @param {number[]} trail */
  #showTrail(trail) {
    const { width } = this.#source;
    const points = trail.map((cell) => this.#centre(cell % width, Math.floor(cell / width))).join(" ");
    if (points === this.#trailPoints) return;
    this.#trailPoints = points;
    this.#trail.setAttribute("points", points);
  }

  /** @param {number} x @param {number} y @param {number} heading */
  #placeMouse(x, y, heading) {
    const transform = `translate(${this.#centre(x, y, " ")}) rotate(${heading * 90})`;
    setAttributes(this.#mouse, { class: "mouse", transform });
  }

  /** @param {number} x @param {number} y */
  #centre(x, y, separator = ",") {
    return `${(x + 0.5) * PITCH}${separator}${(this.#source.height - y - 0.5) * PITCH}`;
  }

  /** The cell under the pointer as y * width + x, or null. @param {{ clientX: number, clientY: number }} pointer */
  cellAt({ clientX, clientY }) {
    const { width, height } = this.#source;
    const point = new DOMPoint(clientX, clientY).matrixTransform(this.svg.getScreenCTM()?.inverse());
    const [x, y] = [Math.floor(point.x / PITCH), height - 1 - Math.floor(point.y / PITCH)];
    return x >= 0 && y >= 0 && x < width && y < height ? y * width + x : null;
  }

  /** Outlines a cell, or removes the outline if `cell` is null. @param {number | null} cell */
  highlight(cell) {
    if (cell === null) return this.#cursor.remove();
    const { width, height } = this.#source;
    const y = height - 1 - Math.floor(cell / width);
    setAttributes(this.#cursor, { x: (cell % width) * PITCH, y: y * PITCH });
    this.svg.append(this.#cursor);
  }
}

/**
 * Returns the SVG path of a centred number, or an empty path if the number is negative.
 * @param {number} number @param {DrawingStyle} style
 */
function numberPath(number, { advance, digits }) {
  if (number < 0) return "";
  return [...`${number}`]
    .map((digit, i, { length }) => `M${Number(((i - length / 2) * advance).toFixed(2))} 0${digits[Number(digit)]}`)
    .join("");
}

/** @param {number} cell @param {Source} source @param {State | undefined} state */
export function describeCell(cell, { width, start, goals }, state) {
  const [x, y] = [cell % width, Math.floor(cell / width)];
  const parts = [`cell (${x}, ${y})`];
  if (x === start[0] && y === start[1]) parts.push("start");
  if (goals.some((goal) => goal[0] === x && goal[1] === y)) parts.push("goal");
  if (state) {
    parts.push(`weight ${state.weights[cell]}`);
    if (state.walls[cell] & VISITED) parts.push("visited");
    if (state.x === x && state.y === y) parts.push(`mouse, heading ${HEADINGS[state.heading]}`);
  }
  return parts.join(" · ");
}
