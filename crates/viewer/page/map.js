// @ts-check
// The map: the server's drawing of the maze, in which a state changes only what differs from what is
// drawn. Thousands of elements stand in it, and most stay as they are from state to state.

import { set } from "./dom.js";
import { DX, DY, HEADINGS, VISITED, WALL_BITS } from "./state.js";

/**
 * @typedef {import("./api.js").Drawing} Drawing
 * @typedef {import("./api.js").Source} Source
 * @typedef {import("./state.js").State} State
 * @typedef {Record<"numbers" | "heat" | "trail", boolean>} Layers
 */

const PITCH = 20;
export const dark = matchMedia("(prefers-color-scheme: dark)");

/** Elements with one attribute that a number stands for: what is drawn is remembered as that number. */
class Attributes {
  /** @param {Element[]} elements @param {string} name @param {(value: number, index: number) => string} write */
  constructor(elements, name, write) {
    this.elements = elements;
    this.name = name;
    this.write = write;
    // Whatever the server has drawn, the first state is drawn in full.
    this.drawn = new Int16Array(elements.length).fill(-2);
  }

  /** @param {number} index @param {number} value */
  set(index, value) {
    if (this.drawn[index] === value) return;
    this.drawn[index] = value;
    this.elements[index].setAttribute(this.name, this.write(value, index));
  }
}

export class MazeMap {
  #source;
  #cells;
  #walls;
  #sides;
  #numbers;
  #heats;
  #trail;
  #trailDrawn = "";
  #mouse;
  #cursor = document.createElementNS("http://www.w3.org/2000/svg", "rect");

  /** @param {string} text the server's drawing @param {Source} source @param {Drawing} drawing */
  constructor(text, source, drawing) {
    const parsed = new DOMParser().parseFromString(text, "image/svg+xml").documentElement;
    const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.adoptNode(parsed)));
    const { width, height } = source;
    /** @param {string} selector */
    const all = (selector) => [...svg.querySelectorAll(selector)];
    this.#source = source;
    this.svg = svg;
    this.#trail = all(".trail")[0];
    this.#mouse = all(".mouse")[0];

    const cells = all(".cell");
    const plain = cells.map((cell) => (cell.getAttribute("class") ?? "").replace(" visited", ""));
    this.#cells = new Attributes(cells, "class", (visited, i) => plain[i] + (visited ? " visited" : ""));

    const walls = all(".wall");
    const stands = walls.map((wall) => wall.classList.contains("true"));
    this.#walls = new Attributes(walls, "class", (believed, i) => {
      const wall = stands[i] ? "wall true" : "wall";
      return !believed ? wall : stands[i] || !source.truth ? `${wall} known` : "wall mistaken";
    });
    /** Where beliefs in a wall stand: in the cells on both sides. */
    this.#sides = walls.map((wall) => {
      const [x, y, side] = (wall.getAttribute("data-wall") ?? "").split(",");
      const heading = "NESW".indexOf(side);
      const [column, row] = [Number(x) + DX[heading], Number(y) + DY[heading]];
      const outer = column < 0 || row < 0 || column >= width || row >= height;
      const [bit, back] = [WALL_BITS[heading], WALL_BITS[(heading + 2) % 4]];
      return { outer, cell: Number(y) * width + Number(x), bit, other: row * width + column, back };
    });

    /** @type {string[]} */
    const texts = [];
    this.#numbers = new Attributes(all(".number"), "d", (number) => (texts[number] ??= strokes(number, drawing)));
    const colours = [...drawing.heat.light, ...drawing.heat.dark];
    this.#heats = new Attributes(all(".heat"), "fill", (heat) => (heat < 0 ? "none" : colours[heat]));

    this.#cursor.setAttribute("class", "cursor");
    this.#cursor.setAttribute("width", `${PITCH}`);
    this.#cursor.setAttribute("height", `${PITCH}`);
    this.#showWalls(new Uint8Array(cells.length));
    this.#place(source.start[0], source.start[1], 0);
  }

  /** @param {State} state @param {number[]} trail cells, oldest first @param {Layers} layers */
  show(state, trail, layers) {
    for (const [layer, shown] of Object.entries(layers)) this.svg.classList.toggle(`hide-${layer}`, !shown);
    this.#showWalls(state.walls);
    // A hidden layer is drawn when it is asked for.
    if (layers.numbers) this.#showNumbers(state.weights);
    if (layers.heat) this.#showHeat(state.weights);
    if (layers.trail) this.#showTrail(trail);
    this.#place(state.x, state.y, state.heading);
  }

  /** @param {Uint8Array} walls */
  #showWalls(walls) {
    for (let i = 0; i < walls.length; i++) this.#cells.set(i, walls[i] & VISITED);
    for (let i = 0; i < this.#sides.length; i++) {
      const { outer, cell, bit, other, back } = this.#sides[i];
      this.#walls.set(i, outer || walls[cell] & bit || walls[other] & back ? 1 : 0);
    }
  }

  /** @param {Uint8Array} weights */
  #showNumbers(weights) {
    const some = weights.some((weight) => weight > 0);
    for (let i = 0; i < weights.length; i++) this.#numbers.set(i, some ? weights[i] : -1);
  }

  /** @param {Uint8Array} weights */
  #showHeat(weights) {
    const largest = Math.max(...weights);
    const first = dark.matches ? 64 : 0;
    for (let i = 0; i < weights.length; i++) {
      this.#heats.set(i, largest > 0 ? first + Math.round((weights[i] * 63) / largest) : -1);
    }
  }

  /** @param {number[]} trail */
  #showTrail(trail) {
    const { width } = this.#source;
    const points = trail.map((cell) => this.#centre(cell % width, Math.floor(cell / width))).join(" ");
    if (points === this.#trailDrawn) return;
    this.#trailDrawn = points;
    this.#trail.setAttribute("points", points);
  }

  /** @param {number} x @param {number} y @param {number} heading */
  #place(x, y, heading) {
    set(this.#mouse, "class", "mouse");
    set(this.#mouse, "transform", `translate(${this.#centre(x, y, " ")}) rotate(${heading * 90})`);
  }

  /** @param {number} x @param {number} y */
  #centre(x, y, between = ",") {
    return `${(x + 0.5) * PITCH}${between}${(this.#source.height - y - 0.5) * PITCH}`;
  }

  /** The cell under the pointer, y * width + x. @param {{ clientX: number, clientY: number }} pointer */
  cellAt({ clientX, clientY }) {
    const { width, height } = this.#source;
    const point = new DOMPoint(clientX, clientY).matrixTransform(this.svg.getScreenCTM()?.inverse());
    const [x, y] = [Math.floor(point.x / PITCH), height - 1 - Math.floor(point.y / PITCH)];
    return x >= 0 && y >= 0 && x < width && y < height ? y * width + x : null;
  }

  /** Frames a cell. @param {number | null} cell */
  mark(cell) {
    if (cell === null) return this.#cursor.remove();
    const { width, height } = this.#source;
    this.#cursor.setAttribute("x", `${(cell % width) * PITCH}`);
    this.#cursor.setAttribute("y", `${(height - 1 - Math.floor(cell / width)) * PITCH}`);
    this.svg.append(this.#cursor);
  }
}

/** A number as strokes, centred; nothing below 0. @param {number} number @param {Drawing} drawing */
function strokes(number, { advance, digits }) {
  if (number < 0) return "";
  return [...`${number}`]
    .map((digit, i, { length }) => `M${Number(((i - length / 2) * advance).toFixed(2))} 0${digits[Number(digit)]}`)
    .join("");
}

/** A cell in words. @param {number} cell @param {Source} source @param {State | undefined} state */
export function describeCell(cell, { width, start, goals }, state) {
  const [x, y] = [cell % width, Math.floor(cell / width)];
  const words = [`cell (${x}, ${y})`];
  if (x === start[0] && y === start[1]) words.push("start");
  if (goals.some((goal) => goal[0] === x && goal[1] === y)) words.push("goal");
  if (state) {
    words.push(`weight ${state.weights[cell]}`);
    if (state.walls[cell] & VISITED) words.push("visited");
    if (state.x === x && state.y === y) words.push(`mouse, heading ${HEADINGS[state.heading]}`);
  }
  return words.join(" · ");
}
