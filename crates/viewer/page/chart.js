// @ts-check
// Line chart of the optimistic and pessimistic distance over the run. The pointer shows the values at a state, and a
// click shows the state.

import { HEIGHT, drawGrid, showTicks, tickStep } from "./axis.js";
import { formatNumber, query, setAttributes, setText } from "./dom.js";

/** The maximum number of intervals between ticks of the vertical axis. */
const MAX_INTERVALS = 3;
/** Minimum distance between the centres of two state numbers, in pixels per character and in addition. */
const [CHARACTER, GAP] = [6.5, 30];

/** @typedef {import("./api.js").BoundsHistory} BoundsHistory */

export class Chart {
  #axis;
  #plot;
  /** @type {BoundsHistory} */
  #history = { states: 0, stride: 1, optimistic: [], pessimistic: [] };
  #unit = "steps";
  /** The heights of the horizontal lines of the grid. @type {string[]} */
  #rows = [];

  /** @param {HTMLElement} panel @param {import("./axis.js").Axis} axis @param {(index: number) => void} seek */
  constructor(panel, axis, seek) {
    this.#axis = axis;
    this.#plot = query(panel, ".plot");
    axis.onChange.push(() => this.#scale());
    axis.listen(this.#plot, query(panel, ".timeline .tip"), (index) => this.#history.states > 0 && seek(index), (index) => this.#tip(index));
    this.#scale();
  }

  /**
   * @param {BoundsHistory} history @param {import("./api.js").StateView | null} newest
   * @param {boolean} isTrial true if the distances are time steps
   */
  draw(history, newest, isTrial) {
    if (newest) {
      // The samples of a long run rarely include its newest state.
      history.optimistic.push(newest.optimistic_distance);
      history.pessimistic.push(newest.pessimistic_distance);
    }
    this.#history = history;
    this.#unit = isTrial ? "time steps" : "steps";
    this.#axis.grow(history.states);
    const { states, stride, optimistic, pessimistic } = history;
    const max = Math.max(1, ...optimistic.map(Number), ...pessimistic.map(Number));
    const step = tickStep(max, MAX_INTERVALS);
    const top = Math.ceil(max / step) * step;
    const ticks = Array.from({ length: top / step + 1 }, (_, i) => i * step);
    /** @param {number} distance */
    const y = (distance) => (HEIGHT - (distance / top) * HEIGHT).toFixed(2);
    const last = Math.max(1, states - 1);
    /** Returns a step line, with gaps where there is no path. @param {(number | null)[]} distances */
    const line = (distances) => {
      let path = "";
      distances.forEach((distance, i) => {
        if (distance === null) return;
        const start = i > 0 && distances[i - 1] !== null ? "V" : `M${Math.min(i * stride, last)} `;
        path += `${start}${y(distance)}H${Math.min((i + 1) * stride, last)}`;
      });
      return path;
    };
    // If a path is first found in the last state, its line has no length. A dot marks the end of the line.
    const end = pessimistic.at(-1) ?? null;
    const dot = end === null ? "" : `M${last} ${y(end)}h0`;
    const paths = { optimistic: line(optimistic), pessimistic: line(pessimistic), dot };
    for (const [name, d] of Object.entries(paths)) setAttributes(query(this.#plot, `.${name}`, SVGElement), { d });
    this.#rows = ticks.map(y);
    showTicks(query(this.#plot, ".y"), "top", states > 0 ? ticks.map((tick, i) => [formatNumber(tick), this.#rows[i]]) : []);
    setText(this.#plot, ".y-title", states > 0 ? this.#unit : "");
    this.#scale();
  }

  /** Scales the lines and draws the ticks for the number of states and the width of the axis. */
  #scale() {
    const { last, width } = this.#axis;
    const { states } = this.#history;
    const max = states > 1 ? last : 0;
    const step = tickStep(Math.max(1, max), width / (formatNumber(max).length * CHARACTER + GAP));
    const numbers = states > 0 ? Array.from({ length: Math.floor(max / step) + 1 }, (_, i) => i * step) : [];
    showTicks(query(this.#plot, ".x"), "left", numbers.map((number) => [formatNumber(number), 100 * this.#axis.share(number)]));
    drawGrid(this.#plot, last, this.#rows, numbers);
  }

  /** Describes the distances at a state. Returns "" if there are no states. @param {number} index */
  #tip(index) {
    const { states, stride, optimistic, pessimistic } = this.#history;
    if (states === 0) return "";
    const sample = Math.min(Math.floor(index / stride), optimistic.length - 1);
    const sampled = Math.min(sample * stride, states - 1);
    const since = sampled === index ? "" : ` (at state ${formatNumber(sampled)})`;
    return `State ${formatNumber(index)}: ${this.#describe(optimistic[sample], pessimistic[sample])}${since}`;
  }

  /** @param {number | null} optimistic @param {number | null} pessimistic */
  #describe(optimistic, pessimistic) {
    if (optimistic === null) return "goal unreachable";
    if (pessimistic === null) return `at least ${formatNumber(optimistic)} ${this.#unit}`;
    if (optimistic === pessimistic) return `${formatNumber(optimistic)} ${this.#unit}, proven`;
    return `${formatNumber(optimistic)} to ${formatNumber(pessimistic)} ${this.#unit}`;
  }
}
