// @ts-check
// The horizontal axis that the chart, the events and the slider share. The state with index i is drawn where the thumb
// of the slider is when the state with index i is shown.

import { query, setAttributes, setText } from "./dom.js";

/** The height of a plot in units of its view box. One unit of the width is one unit of the axis. */
export const HEIGHT = 100;

export class Axis {
  /** Index of the last state on the axis, at least 1. */
  last = 1;
  /** The width of the axis in pixels. */
  width = 0;
  /** Called after `last` or `width` has changed. @type {(() => void)[]} */
  onChange = [];
  #area;
  #cursor;
  #slider;

  /** @param {HTMLElement} panel the element with the timeline and its slider */
  constructor(panel) {
    this.#area = query(panel, ".timeline .axis");
    this.#cursor = query(this.#area, ".cursor");
    this.#slider = query(panel, ".slider input", HTMLInputElement);
    new ResizeObserver(() => {
      this.width = this.#area.clientWidth;
      this.#notify();
    }).observe(this.#area);
  }

  /** Makes room for a number of states. @param {number} states */
  grow(states) {
    if (states - 1 > this.last) this.start(states);
  }

  /**
   * Moves the cursor. The axis is not scaled for each new state of a fast search, since the cursor is then at its end.
   * @param {number} states @param {number} target index of the state to show
   */
  show(states, target) {
    const isNewest = target >= states - 1;
    if (!isNewest) this.grow(states);
    const share = isNewest && states > 1 ? 1 : this.share(target);
    this.#cursor.style.left = `${100 * share}%`;
    this.#slider.style.setProperty("--share", `${100 * share}%`);
  }

  /** Returns the position of a state between 0 and 1. @param {number} index */
  share(index) {
    return Math.min(Math.max(0, index), this.last) / this.last;
  }

  /** Returns the index of the nearest state. @param {number} clientX horizontal position in the window, in pixels */
  indexAt(clientX) {
    const { left, width } = this.#area.getBoundingClientRect();
    const share = width > 0 ? (clientX - left) / width : 0;
    return Math.round(Math.min(Math.max(0, share), 1) * this.last);
  }

  /**
   * Shows a tip at the pointer while it is over a plot. A click or a drag with the mouse seeks.
   * @param {HTMLElement} plot @param {HTMLElement} tip @param {(index: number) => void} seek
   * @param {(index: number) => string} describe returns the text of the tip, or "" if there is none
   */
  listen(plot, tip, seek, describe) {
    plot.onclick = ({ clientX }) => seek(this.indexAt(clientX));
    plot.onpointermove = ({ clientX, pointerType, buttons }) => {
      const index = this.indexAt(clientX);
      if (pointerType === "mouse" && buttons & 1) seek(index);
      const text = describe(index);
      tip.hidden = !text;
      if (!text) return;
      setText(tip, "span", text);
      const share = this.share(index);
      tip.style.left = `${100 * share}%`;
      query(tip, "span").style.translate = `${-100 * share}%`;
    };
    plot.onpointerleave = () => (tip.hidden = true);
  }

  /** Begins a new run. @param {number} states */
  start(states) {
    const last = Math.max(1, states - 1);
    if (this.last === last) return;
    this.last = last;
    this.#notify();
  }

  #notify() {
    for (const listener of this.onChange) listener();
  }
}

/**
 * Writes the numbers of an axis.
 * @param {HTMLElement} axis @param {"top" | "left"} side
 * @param {[text: string, distance: number | string][]} ticks each with its distance from the side, in percent
 */
export function showTicks(axis, side, ticks) {
  const labels = ticks.map(([textContent, distance]) => {
    const label = Object.assign(document.createElement("span"), { textContent });
    label.style[side] = `${distance}%`;
    return label;
  });
  axis.replaceChildren(...labels);
}

/**
 * Scales a plot and draws its grid.
 * @param {HTMLElement} plot @param {number} last @param {(number | string)[]} rows @param {number[]} columns
 */
export function drawGrid(plot, last, rows, columns) {
  const lines = [...rows.map((y) => `M0 ${y}H${last}`), ...columns.map((x) => `M${x} 0V${HEIGHT}`)];
  setAttributes(query(plot, "svg", SVGElement), { viewBox: `0 0 ${last} ${HEIGHT}` });
  setAttributes(query(plot, ".grid", SVGElement), { d: lines.join("") });
}

/**
 * Returns the smallest distance between ticks, of the form 1, 2 or 5 times a power of ten, at which no more than `count`
 * ticks are between 0 and `max`.
 * @param {number} max @param {number} count
 */
export function tickStep(max, count) {
  const least = Math.max(1, max / Math.max(1, count));
  const power = 10 ** Math.floor(Math.log10(least));
  return power * (/** @type {number} */ ([1, 2, 5, 10].find((factor) => factor * power >= least - 1e-9)));
}
