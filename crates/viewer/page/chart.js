// @ts-check
// Both costs over the run as lines, with a cursor at the shown state.

import { part, set, write } from "./dom.js";

/** Units of the drawing; above the largest cost is room for its number. */
const [WIDTH, HEIGHT, TOP] = [512, 100, 20];

export class Chart {
  #panel;
  #cursor;
  #last = 1;

  /** @param {HTMLElement} panel @param {(at: number) => void} go */
  constructor(panel, go) {
    this.#panel = panel;
    this.#cursor = part(panel, ".plot .cursor", SVGElement);
    const lines = part(panel, ".plot svg", SVGElement);
    part(panel, ".plot").onclick = ({ clientX }) => {
      const { left, width } = lines.getBoundingClientRect();
      go(Math.round(((clientX - left) / width) * this.#last));
    };
  }

  /** @param {import("./api.js").Costs} costs @param {import("./api.js").Moment | null} newest */
  draw({ states, stride, open, closed }, newest) {
    this.#last = Math.max(1, states - 1);
    if (newest) {
      // Which is seldom among the costs of a long run.
      open.push(newest.open);
      closed.push(newest.closed);
    }
    const most = Math.max(1, ...open.map(Number), ...closed.map(Number));
    /** @param {number} cost */
    const top = (cost) => (HEIGHT - (cost / most) * (HEIGHT - TOP)).toFixed(1);
    /** A step for each value, since a cost holds until the next one. @param {(number | null)[]} costs */
    const line = (costs) => {
      let path = "";
      costs.forEach((cost, i) => {
        if (cost === null) return;
        path += `${i > 0 && costs[i - 1] !== null ? "V" : `M${this.#left(i * stride)} `}${top(cost)}H${this.#left((i + 1) * stride)}`;
      });
      return path;
    };
    part(this.#panel, ".plot .open", SVGElement).setAttribute("d", line(open));
    part(this.#panel, ".plot .closed", SVGElement).setAttribute("d", line(closed));
    // A way that is known since the newest state is a line of no length yet.
    const known = closed.at(-1) ?? null;
    part(this.#panel, ".plot .dot", SVGElement).setAttribute("d", known === null ? "" : `M${WIDTH} ${top(known)}h0`);
    write(this.#panel, ".most", states > 0 ? most : "");
  }

  /** @param {number} at */
  show(at) {
    set(this.#cursor, "transform", `translate(${this.#left(at)} 0)`);
  }

  /** @param {number} at */
  #left(at) {
    return ((Math.min(at, this.#last) / this.#last) * WIDTH).toFixed(1);
  }
}
