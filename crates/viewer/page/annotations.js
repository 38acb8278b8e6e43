// @ts-check
// The texts and colours that a mouse displays in the cells, as in the simulator mms.

import { setAttributes, svgElement } from "./dom.js";
import { PITCH, corner } from "./state.js";

/** @typedef {import("./api.js").DrawingStyle} DrawingStyle */

export class CellAnnotations {
  #size;
  #style;
  #texts = new Layer("path");
  #colours = new Layer("rect");

  /** @param {SVGSVGElement} svg @param {{ width: number, height: number }} size @param {DrawingStyle} style */
  constructor(svg, size, style) {
    this.#size = size;
    this.#style = style;
    this.#texts.group = svg.querySelector(".texts");
    this.#colours.group = svg.querySelector(".colours");
  }

  /** @param {[number, string][]} texts each with its cell @param {string} colours a letter per cell, or empty */
  show(texts, colours) {
    this.#texts.show(texts.map(([cell, text]) => [cell, `${labelClass(colours[cell], this.#style)} ${text}`]), (cell, value) => {
      const at = value.indexOf(" ");
      const [label, text] = [value.slice(0, at), value.slice(at + 1)];
      const { path, scale } = textPath(text, this.#style);
      const [x, y] = corner(cell, this.#size);
      const position = `translate(${x + PITCH / 2} ${y + PITCH / 2})${scale === 1 ? "" : ` scale(${scale})`}`;
      const className = label ? `text ${label}` : "text";
      return { class: className, "data-cell": this.#name(cell), "data-text": text, transform: position, d: path };
    });
    const coloured = [...colours].flatMap((letter, cell) => (letter === "-" ? [] : [/** @type {[number, string]} */ ([cell, letter])]));
    this.#colours.show(coloured, (cell, letter) => {
      const [x, y] = corner(cell, this.#size);
      const { inset } = this.#style;
      const side = PITCH - 2 * inset;
      const area = { x: x + inset, y: y + inset, width: side, height: side };
      return { class: "colour", "data-cell": this.#name(cell), ...area, fill: this.#style.colours[letter] };
    });
  }

  /** @param {number} cell */
  #name(cell) {
    return `${cell % this.#size.width},${Math.floor(cell / this.#size.width)}`;
  }
}

/** Elements of some cells. An element exists only while its cell has a value, and is written when the value changes. */
class Layer {
  /** @type {Element | null} */
  group = null;
  #tag;
  /** @type {Map<number, { element: Element, value: string }>} */
  #shown = new Map();

  /** @param {string} tag */
  constructor(tag) {
    this.#tag = tag;
  }

  /** @param {[number, string][]} values @param {(cell: number, value: string) => Record<string, unknown>} format */
  show(values, format) {
    const cells = new Set(values.map(([cell]) => cell));
    for (const [cell, { element }] of this.#shown) {
      if (cells.has(cell)) continue;
      element.remove();
      this.#shown.delete(cell);
    }
    for (const [cell, value] of values) {
      let shown = this.#shown.get(cell);
      if (shown?.value === value) continue;
      if (!shown) {
        shown = { element: svgElement(this.#tag, {}), value };
        this.#shown.set(cell, shown);
        this.group?.append(shown.element);
      }
      shown.value = value;
      setAttributes(shown.element, format(cell, value));
    }
  }
}

/** The class of a label on a colour. @param {string | undefined} letter @param {DrawingStyle} style */
export function labelClass(letter, { colours, light_colours: light }) {
  if (!letter || !colours[letter]) return "";
  return light.includes(letter) ? "on-light" : "on-dark";
}

/** Returns the SVG path of a line of text, centred on (0, y). @param {string[]} characters @param {DrawingStyle} style */
export function linePath(characters, { advance, glyphs, missing }, y = 0) {
  return characters
    .map((character, i, { length }) => {
      const glyph = glyphs[(character.codePointAt(0) ?? 0) - 32] ?? missing;
      return `M${Number(((i - length / 2) * advance).toFixed(2))} ${y}${glyph}`;
    })
    .join("");
}

/** Returns the SVG path of a text in a cell, and the factor by which it is scaled. @param {string} text @param {DrawingStyle} style */
function textPath(text, style) {
  const { line, full, offset } = style.text;
  const characters = [...text];
  const [first, second] = [characters.slice(0, line), characters.slice(line)];
  const scale = full / Math.max(first.length, second.length, full);
  if (second.length === 0) return { path: linePath(first, style), scale };
  return { path: linePath(first, style, -offset) + linePath(second, style, offset), scale };
}
