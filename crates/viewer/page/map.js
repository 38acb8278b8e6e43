// @ts-check
// The map of the maze, which is an SVG drawn by the server. For each state, the page updates only the elements that
// change, since most of the thousands of elements stay the same.

import { setAttributes, svgElement } from "./dom.js";
import { CellAnnotations, labelClass, linePath } from "./annotations.js";
import { HEADINGS, NO_PATH, PITCH, VISITED, centre, corner, reportedWalls } from "./state.js";

/**
 * @typedef {import("./api.js").DrawingStyle} DrawingStyle
 * @typedef {import("./api.js").Source} Source
 * @typedef {import("./state.js").State} State
 * @typedef {import("./api.js").StateView} StateView
 * @typedef {Record<"numbers" | "heat" | "trail" | "texts" | "colours" | "shortest" | "plan", boolean>} Layers
 */

/** The value of a wall that the mouse reports as absent, although it exists. */
const MISSED = 2;

/** Elements whose attributes depend on a number per element. They are written when the number changes. */
class Elements {
  /** @param {Element[]} elements @param {(value: number, index: number) => Record<string, string>} format */
  constructor(elements, format) {
    this.elements = elements;
    this.format = format;
    // -2 is not a valid number, so the first state writes all attributes.
    this.values = new Int16Array(elements.length).fill(-2);
  }

  /** @param {number} index @param {number} value */
  set(index, value) {
    if (this.values[index] === value) return;
    this.values[index] = value;
    const attributes = this.format(value, index);
    for (const name in attributes) this.elements[index].setAttribute(name, attributes[name]);
  }
}

export class MazeMap {
  #source;
  #cells;
  #walls;
  /** The number of each wall, as described for `reportedWalls`. Southern and western outer walls have none. */
  #wallNumbers;
  #numbers;
  #numberClasses;
  #annotations;
  #style;
  #heat;
  #passages;
  /** The element of the passage between two cells, by 2 * the southern or western cell + (1 if the other is east). */
  #passageIndex;
  #mouse;
  #routes = ["shortest-route", "planned-route"].map((name) => svgElement("path", { class: name }));
  #cursor = svgElement("rect", { class: "cursor", width: PITCH, height: PITCH });

  /** @param {string} drawing @param {Source} source @param {DrawingStyle} style */
  constructor(drawing, source, style) {
    const parsed = new DOMParser().parseFromString(drawing, "image/svg+xml").documentElement;
    const svg = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.adoptNode(parsed)));
    /** @param {string} selector */
    const all = (selector) => [...svg.querySelectorAll(selector)];
    this.#source = source;
    this.#style = style;
    this.svg = svg;
    this.#annotations = new CellAnnotations(svg, source, style);
    this.#mouse = all(".mouse")[0];
    all(".walls")[0].before(...this.#routes);

    const cells = all(".cell");
    const classes = cells.map((cell) => (cell.getAttribute("class") ?? "").replace(" visited", ""));
    this.#cells = new Elements(cells, (visited, i) => ({ class: classes[i] + (visited ? " visited" : "") }));

    const walls = all(".wall");
    const isTrue = walls.map((wall) => wall.classList.contains("true"));
    this.#walls = new Elements(walls, (reported, i) => {
      const wall = isTrue[i] ? "wall true" : "wall";
      if (reported === MISSED) return { class: `${wall} missed` };
      return { class: !reported ? wall : isTrue[i] || !source.truth ? `${wall} known` : "wall mistaken" };
    });
    /** Returns the cell of a wall or a passage, and the heading of its side. @param {string | null} name */
    const side = (name) => {
      const [column, row, letter] = (name ?? "").split(",");
      return { cell: Number(row) * source.width + Number(column), heading: "NESW".indexOf(letter) };
    };
    this.#wallNumbers = walls.map((wall) => {
      const { cell, heading } = side(wall.getAttribute("data-wall"));
      return heading < 2 ? 2 * cell + heading : -1;
    });

    const passages = all(".passage");
    this.#passageIndex = new Int16Array(2 * cells.length);
    passages.forEach((passage, i) => {
      const { cell, heading } = side(passage.getAttribute("data-passage"));
      this.#passageIndex[2 * cell + heading] = i;
    });
    this.#passages = new Elements(passages, (passage) => this.#passageAttributes(passage));

    /** @type {string[]} */
    const paths = [];
    const numbers = all(".number");
    this.#numberClasses = new Elements(numbers, (code) => ({ class: ["number", "number on-dark", "number on-light"][code] }));
    this.#numbers = new Elements(numbers, (number) => ({ d: (paths[number] ??= numberPath(number, style)) }));
    const { light, dark } = style.heat;
    const colours = light.map((colour, i) => `light-dark(${colour}, ${dark[i]})`);
    this.#heat = new Elements(all(".heat"), (colour) => ({ fill: colour < 0 ? "none" : colours[colour] }));

    this.#showWalls(new Uint8Array(cells.length), [], []);
    this.#placeMouse(source.start[0], source.start[1], 0);
  }

  /** @param {State} state @param {StateView} view @param {Layers} layers */
  show(state, view, layers) {
    const { numbers, heat, trail } = layers;
    const texts = layers.texts ? view.texts : [];
    const colours = layers.colours ? view.colours : "";
    const classes = { "hide-numbers": !numbers, "hide-heat": !heat, "hide-trail": !trail, "no-labels": !numbers && texts.length === 0 };
    for (const [name, isSet] of Object.entries(classes)) this.svg.classList.toggle(name, isSet);
    this.#showWalls(state.walls, view.declared_walls, view.missed_walls);
    this.#annotations.show(texts, colours);
    // A hidden layer is updated when it is shown again.
    if (numbers) this.#showNumberClasses(colours);
    this.#showWeights(state.weights, texts, { numbers, heat });
    if (trail) this.#showTrail(view.trail);
    const routes = [layers.shortest ? this.#source.route : [], layers.plan ? view.plan : []];
    routes.forEach((cells, i) => setAttributes(this.#routes[i], { d: this.#line(cells) }));
    this.#placeMouse(state.x, state.y, state.heading);
  }

  /**
   * @param {Uint8Array} walls
   * @param {[number, boolean][]} declared walls that override the flags
   * @param {number[]} missed walls that exist, but not according to the mouse
   */
  #showWalls(walls, declared, missed) {
    for (let i = 0; i < walls.length; i++) this.#cells.set(i, walls[i] & VISITED);
    const values = reportedWalls(walls, declared, this.#source);
    for (const wall of missed) values[wall] = MISSED;
    this.#wallNumbers.forEach((wall, i) => this.#walls.set(i, values[wall] ?? 1));
  }

  /** @param {string} colours */
  #showNumberClasses(colours) {
    for (let i = 0; i < this.#numberClasses.elements.length; i++) {
      const label = colours && labelClass(colours[i], this.#style);
      this.#numberClasses.set(i, label ? (label === "on-dark" ? 1 : 2) : 0);
    }
  }

  /**
   * Texts replace weights. If a cell has a text, the weight 0 of other cells is not shown.
   * @param {Uint8Array} weights
   * @param {[number, string][]} texts
   * @param {{ numbers: boolean, heat: boolean }} layers
   */
  #showWeights(weights, texts, { numbers, heat }) {
    let [max, blank] = [1, true];
    for (const weight of weights) {
      if (weight > 0) blank = false;
      if (weight > max && weight !== NO_PATH) max = weight;
    }
    const replaced = new Set(texts.map(([cell]) => cell));
    for (let i = 0; i < weights.length; i++) {
      const weight = weights[i];
      const hidden = blank || (weight === 0 && texts.length > 0 && !replaced.has(i));
      if (numbers) this.#numbers.set(i, hidden || replaced.has(i) ? -1 : weight);
      if (heat) this.#heat.set(i, hidden || weight === NO_PATH ? -1 : Math.round((weight * 63) / max));
    }
  }

  /** @param {number[]} trail */
  #showTrail(trail) {
    const { width } = this.#source;
    const { ages, min_fade: minFade } = this.#style.trail;
    const fade = Math.max(trail.length, minFade);
    const shown = new Int16Array(this.#passages.elements.length).fill(-1);
    trail.forEach((passage, i) => {
      const [from, heading] = [passage >> 2, passage & 3];
      const cell = [from, from, from - width, from - 1][heading];
      const age = ages - 1 - Math.floor(((trail.length - 1 - i) * ages) / fade);
      shown[this.#passageIndex[2 * cell + (heading & 1)]] = passage * ages + age;
    });
    shown.forEach((value, i) => this.#passages.set(i, value));
  }

  /** @param {number} value the passage * ages + its age, or -1 @returns {Record<string, string>} */
  #passageAttributes(value) {
    const { ages, lines, arrows } = this.#style.trail;
    if (value < 0) return { class: "passage", stroke: "none", d: "" };
    const [passage, age] = [Math.floor(value / ages), value % ages];
    const [from, heading] = [passage >> 2, passage & 3];
    const [x, y] = [from % this.#source.width, Math.floor(from / this.#source.width)];
    const arrow = x % 2 === y % 2 ? arrows[heading] : "";
    return {
      class: `passage age${age}`,
      stroke: `url(#trail-${heading & 1 ? "h" : "v"}${age})`,
      d: `M${centre(x, y, this.#source)}${lines[heading]}${arrow}`,
    };
  }

  /** @param {number} x @param {number} y @param {number} heading */
  #placeMouse(x, y, heading) {
    const transform = `translate(${centre(x, y, this.#source)}) rotate(${heading * 90})`;
    setAttributes(this.#mouse, { class: "mouse", transform });
  }

  /** Returns the line through the centres of cells. @param {number[]} cells */
  #line(cells) {
    const { width } = this.#source;
    const points = cells.map((cell) => centre(cell % width, Math.floor(cell / width), this.#source));
    return points.length > 0 ? `M${points.join("L")}` : "";
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
    const [x, y] = corner(cell, this.#source);
    setAttributes(this.#cursor, { x, y });
    this.svg.append(this.#cursor);
  }
}

/**
 * Returns the SVG path of a centred weight, or an empty path if the weight is negative.
 * @param {number} weight @param {DrawingStyle} style
 */
function numberPath(weight, style) {
  if (weight < 0) return "";
  return weight === NO_PATH ? style.infinity : linePath([...`${weight}`], style);
}

/** @param {number} cell @param {Source} source @param {State | undefined} state @param {StateView | undefined} view @param {DrawingStyle} style */
export function describeCell(cell, { width, start, goals }, state, view, style) {
  const [x, y] = [cell % width, Math.floor(cell / width)];
  const parts = [`cell (${x}, ${y})`];
  if (x === start[0] && y === start[1]) parts.push("start");
  if (goals.some((goal) => goal[0] === x && goal[1] === y)) parts.push("goal");
  if (state) {
    const weight = state.weights[cell];
    parts.push(weight === NO_PATH ? "weight ∞ (no path)" : `weight ${weight}`);
    const text = view?.texts.find(([at]) => at === cell)?.[1];
    if (text) parts.push(`text “${text}”`);
    const colour = style.colour_names[view?.colours[cell] ?? ""];
    if (colour) parts.push(colour);
    if (state.walls[cell] & VISITED) parts.push("visited");
    if (state.x === x && state.y === y) parts.push(`mouse, heading ${HEADINGS[state.heading]}`);
  }
  // Only visited cells have an entry.
  const [, sides = 0] = view?.unknown_walls.find(([at]) => at === cell) ?? [];
  const unknown = HEADINGS.filter((_, heading) => sides & (1 << heading));
  if (unknown.length > 0) parts.push(`unknown ${unknown.length === 1 ? "wall" : "walls"}: ${unknown.join(", ")}`);
  return parts.join(" · ");
}
