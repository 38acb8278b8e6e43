// @ts-check
// Two layers of a map that show another panel: Ghost draws the mouse and the trail of the other panel, and Differences
// marks the walls that only one of the two mice knows.

import { nextFrame, pluralize, query, setAttributes, setText, svgElement } from "./dom.js";
import { PITCH, centre, corner, reportedWalls } from "./state.js";

/**
 * @typedef {import("./panel.js").Panel} Panel
 * @typedef {import("./figures.js").Shown} Shown
 * @typedef {import("./state.js").Size} Size
 */

/** The lines between the centres of two cells for each heading. */
const LINES = [`v-${PITCH}`, `h${PITCH}`, `v${PITCH}`, `h-${PITCH}`];
/** The ghost's trail is drawn beside the mouse's own trail, by this offset in units of the drawing. */
const OFFSET = 2.8;

export class Ghosts {
  #panels;
  /** The elements that are drawn on each map. @type {WeakMap<SVGSVGElement, Elements>} */
  #drawn = new WeakMap();
  #updating = false;

  /** @param {Map<string, Panel>} panels the open panels by ID */
  constructor(panels) {
    this.#panels = panels;
  }

  /** Updates all maps before the next frame. */
  async update() {
    if (this.#updating) return;
    this.#updating = true;
    await nextFrame();
    this.#updating = false;
    for (const panel of this.#panels.values()) this.#show(panel);
  }

  /** @param {Panel} panel */
  #show(panel) {
    const { element, source, svg, shown } = panel;
    const others = [...this.#panels.values()].filter((other) => other !== panel);
    for (const part of element.querySelectorAll(".compare-layer")) part.toggleAttribute("hidden", others.length === 0);
    const other = chosen(query(element, "[name=other]", HTMLSelectElement), others);
    const [ghost, differences] = ["ghost", "differences"].map((name) => query(element, `[name=${name}]`, HTMLInputElement));
    const isSameSize = source?.width === other?.source?.width && source?.height === other?.source?.height;
    const sizes = [source, other?.source].map((size) => `${size?.width} × ${size?.height}`).join(" and ");
    const reason = source && other?.source && !isSameSize ? `Ghost and Differences need mazes of the same size, not ${sizes}.` : "";
    ghost.disabled = differences.disabled = reason !== "";
    if (svg && !this.#drawn.has(svg)) this.#drawn.set(svg, new Elements(svg));
    const elements = svg ? this.#drawn.get(svg) : undefined;
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
      const [own, others] = [shown, other].map(({ state, view }) => reportedWalls(state.walls, view.declared_walls, size));
      own.forEach((reported, wall) => {
        if (reported !== others[wall]) (reported ? here : there).push(wallLine(wall, size));
      });
    }
    setAttributes(this.#here, { d: here.join("") });
    setAttributes(this.#there, { d: there.join("") });
    return shown && other ? [here.length - 1, there.length - 1] : null;
  }
}

/** @param {number} wall @param {Size} size */
function wallLine(wall, size) {
  const [x, y] = corner(wall >> 1, size);
  return wall & 1 ? `M${x + PITCH} ${y}v${PITCH}` : `M${x} ${y}h${PITCH}`;
}
