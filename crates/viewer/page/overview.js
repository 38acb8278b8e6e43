// @ts-check
// The chart and the events of a run, which are updated at a slow interval and not for each state.

import * as api from "./api.js";
import { Chart } from "./chart.js";
import { Marks } from "./marks.js";

export class Overview {
  #timeline;
  #chart;
  marks;
  /** Number of states in the chart. */
  #states = -1;
  #isLoading = false;

  /** @param {HTMLElement} panel @param {import("./timeline.js").Timeline} timeline */
  constructor(panel, timeline) {
    this.#timeline = timeline;
    this.#chart = new Chart(panel, timeline.axis, (index) => timeline.seek(index));
    this.marks = new Marks(panel, timeline);
  }

  /** True if nothing of the current run is drawn or requested. */
  get isEmpty() {
    return this.#states < 0 && !this.#isLoading;
  }

  /** Begins a new run. */
  clear() {
    this.#states = -1;
    this.#isLoading = false;
  }

  /**
   * Loads and draws a run, unless this is done already. Returns false if this fails or is in progress.
   * @param {api.Source} source @param {number} states @param {boolean} isTrial @param {AbortSignal} signal
   */
  async update(source, states, isTrial, signal) {
    if (this.#isLoading) return false;
    if (this.#states === states) return true;
    this.#isLoading = true;
    const requests = Promise.all([api.distances(source, signal), api.runEvents(source, signal)]);
    const [history, events] = (await requests.catch(() => null)) ?? [];
    if (!history || !events) {
      if (!signal.aborted) this.#isLoading = false;
      return false;
    }
    const newest = history.stride > 1 ? api.stateView(source, history.states - 1, signal) : null;
    const view = await newest?.catch(() => null);
    if (signal.aborted) return false;
    this.#isLoading = false;
    this.#states = states;
    // The history may be newer than the last event.
    this.#timeline.grow(history.states);
    if (!this.#timeline.following) this.#timeline.show();
    this.#chart.draw(history, view ?? null, isTrial);
    this.marks.draw(events);
    return true;
  }
}
