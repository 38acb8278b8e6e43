// @ts-check
// Two layers of a map that show another panel: Ghost draws the mouse and the trail of the other panel, and Differences
// marks the walls that only one of the two mice knows.

import { nextFrame, pluralize, query, setAttributes, setText, svgElement } from "./dom.js";
import { PITCH, WALL_BITS, centre } from "./state.js";

/**
 * @typedef {import("./panel.js").Panel} Panel
 * @typedef {import("./figures.js").Shown} Shown
 * @typedef {import("./state.js").Size} Size
 */

const [NORTH, EAST, SOUTH, WEST] = WALL_BITS;
/** The lines between the centres of two cells for each heading. */
const LINES = [`v-${PITCH}`, `h${PITCH}`, `v${PITCH}`, `h-${PITCH}`];
/** The ghost's trail is drawn beside the mouse's own trail, by this offset in units of the drawing. */
const OFFSET = 2.8;

export class Ghosts {
  /** The panels with the elements that are drawn on their maps. @type {Map<Panel, Elements | null>} */
  #panels = new Map();
  #updating = false;

  /** @param {Panel} panel */
  add(panel) {
    this.#panels.set(panel, null);
    void this.update();
  }

  /** @param {Panel} panel */
  remove(panel) {
    this.#panels.delete(panel);
    void this.update();
  }

  /** Updates all maps before the next frame. */
  async update() {
    if (this.#updating) return;
    this.#updating = true;
    await nextFrame();
    this.#updating = false;
    for (const panel of this.#panels.keys()) this.#show(panel);
  }

  /** @param {Panel} panel */
  #show(panel) {
    const { element, source, svg, shown } = panel;
    const others = [...this.#panels.keys()].filter((other) => other !== panel);
    for (const part of element.querySelectorAll(".compare-layer")) part.toggleAttribute("hidden", others.length === 0);
    const other = chosen(query(element, "[name=other]", HTMLSelectElement), others);
    const [ghost, differences] = ["ghost", "differences"].map((name) => query(element, `[name=${name}]`, HTMLInputElement));
    const isSameSize = source?.width === other?.source?.width && source?.height === other?.source?.height;
    const sizes = [source, other?.source].map((size) => `${size?.width} × ${size?.height}`).join(" and ");
    const reason = source && other?.source && !isSameSize ? `Ghost and Differences need mazes of the same size, not ${sizes}.` : "";
    ghost.disabled = differences.disabled = reason !== "";
    let elements = this.#panels.get(panel) ?? null;
    if (svg && elements?.svg !== svg) this.#panels.set(panel, (elements = new Elements(svg)));
    const compared = source && isSameSize && shown && other?.shown ? other.shown : null;
    elements?.showGhost(ghost.checked ? compared : null, source);
    const walls = elements?.showDifferences(shown, differences.checked ? compared : null, source);
    const [here, there] = walls ?? [0, 0];
    const isSameMaze = source?.maze === other?.source?.maze;
    const counts = walls ? `${pluralize(here, "wall")} known only here, ${there} only there${isSameMaze ? "" : " (another maze)"}` : "";
    setText(element, ".differences", reason || counts);
  }
}

/** Lists the other panels, and returns the selected one. @param {HTMLSelectElement} select @param {Panel[]} others */
function chosen(select, others) {
  const options = others.map((other) => [other.id, `${other.source?.title ?? ""}${other.id === "live" ? " (live)" : ""}`]);
  const isListed = options.every(([id, text], i) => select.options[i]?.value === id && select.options[i].text === text);
  if (!isListed || select.options.length !== options.length) {
    const { value } = select;
    select.replaceChildren(...options.map(([id, text]) => new Option(text, id, false, id === value)));
  }
  select.hidden = others.length < 2;
  return others.find(({ id }) => id === select.value);
}

/** The elements of both layers on a map. */
class Elements {
  #trail = svgElement("path", { class: "ghost-trail", transform: `translate(${OFFSET} ${OFFSET})` });
  #mouse;
  #here = svgElement("path", { class: "only-here" });
  #there = svgElement("path", { class: "only-there" });

  /** @param {SVGSVGElement} svg */
  constructor(svg) {
    this.svg = svg;
    const mouse = svg.querySelector(".mouse");
    this.#mouse = svgElement("path", { class: "ghost-mouse", d: mouse?.getAttribute("d") ?? "" });
    const walls = svg.querySelector(".walls");
    walls?.before(this.#trail, this.#here);
    walls?.after(this.#there);
    mouse?.before(this.#mouse);
  }

  /** @param {Shown | null} other @param {Size | null} size */
  showGhost(other, size) {
    this.#mouse.toggleAttribute("hidden", !other);
    if (!other || !size) return void setAttributes(this.#trail, { d: "" });
    const { x, y, heading } = other.state;
    const lines = other.view.trail.map((passage) => {
      const cell = passage >> 2;
      return `M${centre(cell % size.width, Math.floor(cell / size.width), size)}${LINES[passage & 3]}`;
    });
    setAttributes(this.#trail, { d: lines.join("") });
    setAttributes(this.#mouse, { transform: `translate(${centre(x, y, size)}) rotate(${heading * 90})` });
  }

  /**
   * Marks the walls that only one of two states reports. Returns their numbers.
   * @param {Shown | null} shown @param {Shown | null} other @param {Size | null} size
   */
  showDifferences(shown, other, size) {
    const [here, there] = [[""], [""]];
    if (shown && other && size) {
      const [own, others] = [reportedWalls(shown, size), reportedWalls(other, size)];
      own.forEach((reported, wall) => {
        if (reported !== others[wall]) (reported ? here : there).push(wallLine(wall, size));
      });
    }
    setAttributes(this.#here, { d: here.join("") });
    setAttributes(this.#there, { d: there.join("") });
    return shown && other ? [here.length - 1, there.length - 1] : null;
  }
}

/**
 * Returns 1 for each inner wall that the mouse reports, by 2 * its cell + (1 if it is an east wall, 0 if it is a north wall).
 * @param {Shown} shown @param {Size} size
 */
function reportedWalls({ state: { walls }, view }, { width, height }) {
  const reported = new Uint8Array(2 * width * height);
  for (let cell = 0; cell < width * height; cell++) {
    const hasNorth = cell + width < width * height;
    const hasEast = (cell + 1) % width > 0;
    if (hasNorth && (walls[cell] & NORTH || walls[cell + width] & SOUTH)) reported[2 * cell] = 1;
    if (hasEast && (walls[cell] & EAST || walls[cell + 1] & WEST)) reported[2 * cell + 1] = 1;
  }
  for (const [wall, isPresent] of view.declared_walls) {
    const cell = wall >> 1;
    const isInner = wall & 1 ? (cell + 1) % width > 0 : cell + width < width * height;
    if (isInner) reported[wall] = Number(isPresent);
  }
  return reported;
}

/** @param {number} wall @param {Size} size */
function wallLine(wall, { width, height }) {
  const cell = wall >> 1;
  const [x, y] = [(cell % width) * PITCH, (height - 1 - Math.floor(cell / width)) * PITCH];
  return wall & 1 ? `M${x + PITCH} ${y}v${PITCH}` : `M${x} ${y}h${PITCH}`;
}
