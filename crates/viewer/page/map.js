// @ts-check
// The map: the server's drawing of the maze, in which a state then changes only what differs from
// what is drawn. Thousands of elements stand in it, and most stay as they are from state to state.

import { HEADINGS, VISITED, WALL_BITS } from "./state.js";

/**
 * @typedef {import("./api.js").Drawing} Drawing
 * @typedef {import("./api.js").Source} Source
 * @typedef {import("./state.js").State} State
 * @typedef {"numbers" | "heat" | "trail"} Layer
 */

const PITCH = 20;
const SVG = "http://www.w3.org/2000/svg";
const dark = matchMedia("(prefers-color-scheme: dark)");

export class MazeMap {
    #source;
    #drawing;
    #svg;
    #cells;
    #heats;
    #numbers;
    #walls;
    #trail;
    #mouse;
    /** Where a wall is looked up: the first cell, its bit, the second cell (or the first), its bit. */
    #sides;
    /** Classes of cells and walls by what is believed of them. */
    #cellClasses;
    #wallClasses;
    /** What is drawn, by element: to compare, so that what stays is not touched. */
    #visitedDrawn;
    #wallsDrawn;
    #numbersDrawn;
    #heatsDrawn;
    #trailDrawn = "";
    /** @type {string[]} */
    #digits = [];
    #cursor = document.createElementNS(SVG, "rect");

    /** @param {string} text the server's drawing @param {Source} source @param {Drawing} drawing */
    constructor(text, source, drawing) {
        const parsed = new DOMParser().parseFromString(text, "image/svg+xml");
        const svg = /** @type {SVGSVGElement} */ (
            /** @type {unknown} */ (document.importNode(parsed.documentElement, true))
        );
        const { width, height } = source;
        /** @param {string} selector */
        const all = (selector) => [...svg.querySelectorAll(selector)];
        this.#source = source;
        this.#drawing = drawing;
        this.#svg = svg;
        this.#cells = all(".cell");
        this.#heats = all(".heat");
        this.#numbers = all(".number");
        this.#walls = all(".wall");
        this.#trail = all(".trail")[0];
        this.#mouse = all(".mouse")[0];
        this.#sides = this.#walls.map((wall) => {
            const [x, y, side] = (wall.getAttribute("data-wall") ?? "").split(",");
            const heading = "NESW".indexOf(side);
            const cell = Number(y) * width + Number(x);
            const [ox, oy] = [Number(x) + [0, 1, 0, -1][heading], Number(y) + [1, 0, -1, 0][heading]];
            const outer = ox < 0 || oy < 0 || ox >= width || oy >= height;
            const other = outer ? cell : oy * width + ox;
            return { cell, bit: WALL_BITS[heading], other, back: WALL_BITS[(heading + 2) % 4], outer };
        });
        this.#cellClasses = this.#cells.map((cell) => {
            const plain = (cell.getAttribute("class") ?? "").replace(" visited", "");
            return [plain, `${plain} visited`];
        });
        this.#wallClasses = this.#walls.map((wall) => {
            const stands = wall.classList.contains("true");
            const plain = stands ? "wall true" : "wall";
            return [plain, stands || !source.truth ? `${plain} known` : "wall mistaken"];
        });
        // Whatever the server has drawn, the first state is drawn in full.
        this.#visitedDrawn = new Int8Array(this.#cells.length).fill(-1);
        this.#wallsDrawn = new Int8Array(this.#walls.length).fill(-1);
        this.#numbersDrawn = new Int16Array(this.#cells.length).fill(-2);
        this.#heatsDrawn = new Int16Array(this.#cells.length).fill(-2);
        this.#cursor.setAttribute("class", "cursor");
        this.#cursor.setAttribute("width", String(PITCH));
        this.#cursor.setAttribute("height", String(PITCH));
        this.#place(source.start[0], source.start[1], 0);
        svg.setAttribute("data-height", String(height));
    }

    get svg() {
        return this.#svg;
    }

    /** @param {State} state @param {number[]} trail cells, oldest first @param {Record<Layer, boolean>} layers */
    show(state, trail, layers) {
        this.#showWalls(state.walls);
        for (const layer of /** @type {Layer[]} */ (["numbers", "heat", "trail"])) {
            this.#svg.classList.toggle(`hide-${layer}`, !layers[layer]);
        }
        // A hidden layer is drawn when it is asked for.
        if (layers.numbers) this.#showNumbers(state.weights);
        if (layers.heat) this.#showHeat(state.weights);
        if (layers.trail) this.#showTrail(trail);
        this.#place(state.x, state.y, state.heading);
    }

    /** @param {Uint8Array} walls */
    #showWalls(walls) {
        for (let i = 0; i < this.#cells.length; i++) {
            const visited = walls[i] & VISITED;
            if (visited === this.#visitedDrawn[i]) continue;
            this.#visitedDrawn[i] = visited;
            this.#cells[i].setAttribute("class", this.#cellClasses[i][visited]);
        }
        for (let i = 0; i < this.#walls.length; i++) {
            const { cell, bit, other, back, outer } = this.#sides[i];
            const believed = outer || walls[cell] & bit || walls[other] & back ? 1 : 0;
            if (believed === this.#wallsDrawn[i]) continue;
            this.#wallsDrawn[i] = believed;
            this.#walls[i].setAttribute("class", this.#wallClasses[i][believed]);
        }
    }

    /** @param {Uint8Array} weights */
    #showNumbers(weights) {
        const some = weights.some((weight) => weight > 0);
        for (let i = 0; i < weights.length; i++) {
            const number = some ? weights[i] : -1;
            if (number === this.#numbersDrawn[i]) continue;
            this.#numbersDrawn[i] = number;
            this.#numbers[i].setAttribute("d", number < 0 ? "" : this.#digitsOf(number));
        }
    }

    /** A number as strokes, centred. @param {number} number */
    #digitsOf(number) {
        const { advance, digits } = this.#drawing;
        return (this.#digits[number] ??= [...String(number)]
            .map((digit, i, all) => {
                const left = Number(((i - all.length / 2) * advance).toFixed(2));
                return `M${left} 0${digits[Number(digit)]}`;
            })
            .join(""));
    }

    /** @param {Uint8Array} weights */
    #showHeat(weights) {
        const ramp = this.#drawing.heat[dark.matches ? "dark" : "light"];
        const largest = Math.max(...weights);
        for (let i = 0; i < weights.length; i++) {
            const heat = largest > 0 ? Math.round((weights[i] * 63) / largest) : -1;
            const drawn = heat < 0 ? heat : heat + (dark.matches ? 64 : 0);
            if (drawn === this.#heatsDrawn[i]) continue;
            this.#heatsDrawn[i] = drawn;
            this.#heats[i].setAttribute("fill", heat < 0 ? "none" : ramp[heat]);
        }
    }

    /** @param {number[]} trail */
    #showTrail(trail) {
        const { width, height } = this.#source;
        const points = trail
            .map((cell) => {
                const x = cell % width;
                return `${x * PITCH + PITCH / 2},${(height - (cell - x) / width) * PITCH - PITCH / 2}`;
            })
            .join(" ");
        if (points === this.#trailDrawn) return;
        this.#trailDrawn = points;
        this.#trail.setAttribute("points", points);
    }

    /** @param {number} x @param {number} y @param {number} heading */
    #place(x, y, heading) {
        const [left, top] = [x * PITCH + PITCH / 2, (this.#source.height - y) * PITCH - PITCH / 2];
        this.#mouse.setAttribute("class", "mouse");
        this.#mouse.setAttribute("transform", `translate(${left} ${top}) rotate(${heading * 90})`);
    }

    /** The cell under the pointer, y * width + x. @param {{ clientX: number, clientY: number }} pointer */
    cellAt(pointer) {
        const { width, height } = this.#source;
        const screen = this.#svg.getScreenCTM();
        if (!screen) return null;
        const { x, y } = new DOMPoint(pointer.clientX, pointer.clientY).matrixTransform(screen.inverse());
        const [column, row] = [Math.floor(x / PITCH), height - 1 - Math.floor(y / PITCH)];
        return column >= 0 && row >= 0 && column < width && row < height ? row * width + column : null;
    }

    /** Frames a cell. @param {number | null} cell */
    mark(cell) {
        if (cell === null) return this.#cursor.remove();
        const { width, height } = this.#source;
        this.#cursor.setAttribute("x", String((cell % width) * PITCH));
        this.#cursor.setAttribute("y", String((height - 1 - Math.floor(cell / width)) * PITCH));
        this.#svg.append(this.#cursor);
    }
}

/** A cell in words. @param {number} cell @param {Source} source @param {State | null} state */
export function describeCell(cell, { width, start, goals }, state) {
    const [x, y] = [cell % width, Math.floor(cell / width)];
    const words = [`cell (${x}, ${y})`];
    if (x === start[0] && y === start[1]) words.push("start");
    if (goals.some((goal) => goal[0] === x && goal[1] === y)) words.push("goal");
    if (state) {
        words.push(`weight ${state.weights[cell]}`);
        words.push(state.walls[cell] & VISITED ? "visited" : "not visited");
        if (state.x === x && state.y === y) words.push(`mouse heading ${HEADINGS[state.heading]}`);
    }
    return words.join(" · ");
}
