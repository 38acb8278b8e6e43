// @ts-check
// Line chart of the optimistic and pessimistic distance over the run, with a cursor at the shown state and marks at the
// states in which the mouse was put back at the start.

import { query, setAttributes, setText } from "./dom.js";

/** The dimensions in units of the view box. The space above y = TOP contains the label of the maximum. */
const [WIDTH, HEIGHT, TOP] = [512, 100, 20];
/** The length of the mark where the mouse was put back at the start. */
const MARK = 14;

export class Chart {
  #panel;
  #cursor;
  #last = 1;

  /** @param {HTMLElement} panel @param {(index: number) => void} seek */
  constructor(panel, seek) {
    this.#panel = panel;
    this.#cursor = query(panel, ".plot .cursor", SVGElement);
    const svg = query(panel, ".plot svg", SVGElement);
    query(panel, ".plot").onclick = ({ clientX }) => {
      const { left, width } = svg.getBoundingClientRect();
      seek(Math.round(((clientX - left) / width) * this.#last));
    };
  }

  /** @param {import("./api.js").DistanceHistory} history @param {import("./api.js").StateView | null} newest */
  draw({ states, stride, open, closed, restarts }, newest) {
    this.#last = Math.max(1, states - 1);
    if (newest) {
      // The samples of a long run rarely include its newest state.
      open.push(newest.open);
      closed.push(newest.closed);
      restarts.push(newest.phases.restarts);
    }
    const max = Math.max(1, ...open.map(Number), ...closed.map(Number));
    /** @param {number} distance */
    const y = (distance) => (HEIGHT - (distance / max) * (HEIGHT - TOP)).toFixed(1);
    /** Returns a step line, with gaps where there is no path. @param {(number | null)[]} distances */
    const line = (distances) => {
      let path = "";
      distances.forEach((distance, i) => {
        if (distance === null) return;
        path += `${i > 0 && distances[i - 1] !== null ? "V" : `M${this.#x(i * stride)} `}${y(distance)}H${this.#x((i + 1) * stride)}`;
      });
      return path;
    };
    query(this.#panel, ".plot .optimistic", SVGElement).setAttribute("d", line(open));
    query(this.#panel, ".plot .pessimistic", SVGElement).setAttribute("d", line(closed));
    const marks = restarts.map((count, i) => (count > (restarts[i - 1] ?? 0) ? `M${this.#x(i * stride)} 0v${MARK}` : ""));
    query(this.#panel, ".plot .restarts", SVGElement).setAttribute("d", marks.join(""));
    // If a path is first found in the last state, its line has no length. A dot marks the end of the line.
    const end = closed.at(-1) ?? null;
    query(this.#panel, ".plot .dot", SVGElement).setAttribute("d", end === null ? "" : `M${WIDTH} ${y(end)}h0`);
    setText(this.#panel, ".max", states > 0 ? max : "");
  }

  /** @param {number} index */
  setCursor(index) {
    setAttributes(this.#cursor, { transform: `translate(${this.#x(index)} 0)` });
  }

  /** @param {number} index */
  #x(index) {
    return ((Math.min(index, this.#last) / this.#last) * WIDTH).toFixed(1);
  }
}
