// @ts-check
// Both costs over the run as lines, with a cursor at the shown state.

import { part, write } from "./dom.js";

/** @typedef {import("./api.js").Costs} Costs */

const WIDTH = 512;
const HEIGHT = 100;

export class Chart {
    #element;
    #cursor;
    #states = 1;

    /** @param {HTMLElement} element the figure @param {(at: number) => void} go */
    constructor(element, go) {
        this.#element = element;
        this.#cursor = part(element, ".cursor", SVGElement);
        const plot = part(element, "svg", SVGSVGElement);
        plot.onclick = ({ clientX }) => {
            const { left, width } = plot.getBoundingClientRect();
            go(Math.round(((clientX - left) / width) * (this.#states - 1)));
        };
    }

    /** @param {Costs} costs */
    draw({ states, stride, open, closed }) {
        this.#states = Math.max(2, states);
        const most = Math.max(1, ...open.map(Number), ...closed.map(Number));
        /** A step for each value: a cost holds until the next state. @param {(number | null)[]} costs */
        const line = (costs) => {
            let path = "";
            for (let i = 0; i < costs.length; i++) {
                const cost = costs[i];
                if (cost === null) continue;
                const left = this.#left(i * stride);
                const right = this.#left(Math.min((i + 1) * stride, states - 1));
                const top = ((1 - cost / most) * HEIGHT).toFixed(1);
                path += `${i > 0 && costs[i - 1] !== null ? "V" : `M${left} `}${top}H${right}`;
            }
            return path;
        };
        part(this.#element, ".open", SVGElement).setAttribute("d", line(open));
        part(this.#element, ".closed", SVGElement).setAttribute("d", line(closed));
        write(part(this.#element, ".most", HTMLElement), states > 0 ? String(most) : "");
    }

    /** @param {number} at */
    show(at) {
        const left = this.#left(Math.max(0, at));
        this.#cursor.setAttribute("transform", `translate(${left} 0)`);
    }

    /** @param {number} at */
    #left(at) {
        return Number(((Math.min(at, this.#states - 1) / (this.#states - 1)) * WIDTH).toFixed(1));
    }
}
