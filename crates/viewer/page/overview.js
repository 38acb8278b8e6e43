// @ts-check
// The chart of a run, which is updated at a slow interval and not for each state.

import * as api from "./api.js";
import { Chart } from "./chart.js";

export class Overview {
  #chart;
  /** Number of states in the chart. */
  #states = -1;

  /** @param {HTMLElement} panel @param {import("./timeline.js").Timeline} timeline */
  constructor(panel, timeline) {
    this.#chart = new Chart(panel, timeline.axis, (index) => timeline.seek(index));
  }

  /** True if nothing is drawn of the current run. */
  get isEmpty() {
    return this.#states < 0;
  }

  /** Begins a new run. */
  clear() {
    this.#states = -1;
  }

  /**
   * Loads and draws a run, unless this is done already. Returns false if this fails.
   * @param {api.Source} source @param {number} states @param {boolean} isTrial @param {AbortSignal} signal
   */
  async update(source, states, isTrial, signal) {
    if (this.#states === states) return true;
    const history = await api.distances(source, signal).catch(() => null);
    if (!history) return false;
    const newest = history.stride > 1 ? api.stateView(source, history.states - 1, signal) : null;
    const view = await newest?.catch(() => null);
    if (signal.aborted) return false;
    this.#states = states;
    this.#chart.draw(history, view ?? null, isTrial);
    return true;
  }
}
