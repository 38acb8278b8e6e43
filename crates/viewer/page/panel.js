// @ts-check
// A panel shows one source of states, the live simulation or a recording: its map, its history and
// the figures of the shown state.

import * as api from "./api.js";
import { Chart } from "./chart.js";
import { copy, counted, frame, part, pause, report, write } from "./dom.js";
import { MazeMap, describeCell } from "./map.js";
import { HEADINGS, readState } from "./state.js";
import { Timeline } from "./timeline.js";

/** Milliseconds between draws while states stream in: every other frame of a usual screen. */
const LIVE_PAUSE = 25;
/** Milliseconds between runs: a client may reset as often as it likes. */
const BEGIN_PAUSE = 100;
/** Milliseconds between looks at the costs, and until what has settled is said. */
const SLOW = 1000;

const dark = matchMedia("(prefers-color-scheme: dark)");

export class Panel {
    element = copy("panel");
    timeline;
    #id;
    #drawingFacts;
    #chart;
    /** @type {api.Source | null} */
    #source = null;
    /** @type {MazeMap | null} */
    #map = null;
    #abort = new AbortController();
    #beginning = false;
    /** The run that the server told of last. */
    #run = NaN;
    #drawing = false;
    /** The shown state: its index, -1 for none, what it says and what follows from it. */
    #at = -1;
    /** @type {import("./state.js").State | null} */
    #state = null;
    /** @type {api.Moment | null} */
    #moment = null;
    #drawnAt = 0;
    #slowTimer = 0;
    #told = -1;
    #costsOf = -1;
    /** The cell under the pointer or chosen by keys. @type {number | null} */
    #cell = null;

    /** @param {string} id @param {api.Drawing} drawing */
    constructor(id, drawing) {
        this.#id = id;
        this.#drawingFacts = drawing;
        this.element.dataset.source = id;
        this.timeline = new Timeline(this.element, id === "live", () => {
            this.timeline.show();
            void this.#draw();
        });
        this.#chart = new Chart(this.#part(".chart"), (at) => this.timeline.go(at));
        this.#part(".layers").onchange = () => this.#show();
        dark.addEventListener("change", () => this.#show());
        this.#watchPointer();
        for (const event of ["pointerdown", "keydown", "focusin"]) {
            this.#part(".export").addEventListener(event, () => this.#address());
        }
    }

    /** @param {string} selector */
    #part(selector) {
        return part(this.element, selector, HTMLElement);
    }

    /** @param {string} name */
    #layer(name) {
        return part(this.element, `[name=${name}]`, HTMLInputElement).checked;
    }

    get #layers() {
        return {
            numbers: this.#layer("numbers"),
            heat: this.#layer("heat"),
            trail: this.#layer("trail"),
        };
    }

    /** What the server tells of the live run. @param {number} run @param {number} states */
    follow(run, states) {
        this.#run = run;
        if (this.#source?.run === run) this.timeline.grow(states);
        else void this.begin();
    }

    /** Empties the panel and shows the source as it is now. */
    async begin() {
        if (this.#beginning) return;
        this.#beginning = true;
        this.#abort.abort();
        this.#abort = new AbortController();
        this.#source = null;
        try {
            const source = await api.source(this.#id, this.#abort.signal);
            const text = await api.drawing(source, this.#abort.signal);
            this.#install(source, text);
        } catch (problem) {
            if (!(problem instanceof api.Refused && problem.over)) report(problem);
        }
        await pause(BEGIN_PAUSE);
        this.#beginning = false;
        this.#catchUp();
    }

    /** Begins anew if the run that was begun is over by now. */
    #catchUp() {
        if (this.#source && !Number.isNaN(this.#run) && this.#source.run !== this.#run) void this.begin();
    }

    /** @param {api.Source} source @param {string} text */
    #install(source, text) {
        this.#source = source;
        this.#at = -1;
        this.#state = this.#moment = null;
        this.#costsOf = this.#told = -1;
        this.#map = new MazeMap(text, source, this.#drawingFacts);
        this.#part(".map").replaceChildren(this.#map.svg);
        this.#part(".map").style.setProperty("--ratio", String(source.width / source.height));
        const { element } = this;
        element.dataset.run = String(source.run);
        element.dataset.at = "";
        element.setAttribute("aria-label", this.#id === "live" ? "Live simulation" : `Recording ${source.title}`);
        write(this.#part("h2"), source.title);
        write(this.#part(".kind"), this.#id === "live" ? "live" : "recording");
        write(this.#part(".size"), `${source.width} × ${source.height}`);
        const note = this.#part(".note");
        write(note, source.note ?? "");
        note.hidden = !source.note;
        this.#showFigures();
        this.#point(null);
        this.timeline.begin(source.states);
        clearTimeout(this.#slowTimer);
        this.#slowTimer = 0;
        this.#slowly();
    }

    close() {
        this.#abort.abort();
        clearTimeout(this.#slowTimer);
        this.timeline.go(0);
        this.#source = null;
        this.element.remove();
    }

    /** Draws the wanted state, then the one that is wanted by then, until it is the same: never a queue. */
    async #draw() {
        if (this.#drawing) return;
        this.#drawing = true;
        try {
            while (this.#source && this.timeline.wanted >= 0 && this.timeline.wanted !== this.#at) {
                if (this.timeline.following) {
                    await pause(this.#drawnAt + LIVE_PAUSE - performance.now());
                }
                const { signal } = this.#abort;
                const source = this.#source;
                const at = this.timeline.wanted;
                if (!source) break;
                const [message, moment] = await Promise.all([
                    api.stateMessage(source, at, signal),
                    api.moment(source, at, signal),
                ]);
                await frame();
                if (signal.aborted) continue;
                this.#at = at;
                this.#state = readState(message, source);
                this.#moment = moment;
                this.#show();
                this.#drawnAt = performance.now();
            }
        } catch (problem) {
            if (problem instanceof api.Refused && problem.over) this.#source = null;
            else report(problem);
        }
        this.#drawing = false;
    }

    #show() {
        this.timeline.show();
        if (this.#state && this.#moment) this.#map?.show(this.#state, this.#moment.trail, this.#layers);
        this.#showFigures();
        this.#chart.show(this.#at);
        this.#readout();
        this.element.dataset.at = this.#at < 0 ? "" : String(this.#at);
        this.#slowly();
    }

    #showFigures() {
        const [moment, source] = [this.#moment, this.#source];
        /** @param {string} name @param {number | string | null | undefined} value @param {string} [none] */
        const figure = (name, value, none = "–") => write(this.#part(`.${name} dd`), String(value ?? none));
        figure("steps", moment?.steps);
        figure("turns", moment?.turns);
        figure("visited", moment?.visited);
        figure("open-cost", moment?.open, moment ? "no way" : "–");
        figure("closed-cost", moment?.closed, moment ? "no way" : "–");
        figure("shortest", source?.shortest_path, source?.truth ? "no way" : "not known");
        write(this.#part(".solved"), moment?.solved ? "solved" : "not solved");
        this.element.dataset.solved = String(moment?.solved ?? false);
    }

    /** What need not be told at once: the costs over the run, the exports' addresses, the state in words. */
    #slowly() {
        if (this.#slowTimer) return;
        const late = this.#costsOf < 0 ? 0 : SLOW;
        this.#slowTimer = setTimeout(async () => {
            this.#slowTimer = 0;
            const source = this.#source;
            if (!source) return;
            this.#address();
            const { states } = this.timeline;
            if (this.#costsOf !== states) {
                try {
                    this.#chart.draw(await api.costs(source, this.#abort.signal));
                    this.#chart.show(this.#at);
                    this.#costsOf = states;
                } catch {
                    // The next draw asks again.
                }
            }
            if (this.#told === this.#at) return this.#tell();
            this.#told = this.#at;
            this.#slowly();
        }, late);
    }

    #tell() {
        const [state, moment] = [this.#state, this.#moment];
        const words = [this.#part(".place").textContent];
        if (state && moment) {
            words.push(`mouse at (${state.x}, ${state.y}) heading ${HEADINGS[state.heading]}`);
            words.push(counted(moment.visited, "cell") + " visited");
            words.push(moment.solved ? `solved at ${moment.open}` : "not solved");
        }
        write(this.#part(".words"), words.join(", "));
    }

    /** Puts what is shown into the addresses of the exports. */
    #address() {
        if (!this.#source) return;
        const { numbers, heat, trail } = this.#layers;
        const look = `numbers=${numbers}&heat=${heat}&trail=${trail}&theme=${dark.matches ? "dark" : "light"}`;
        for (const link of this.element.querySelectorAll("a[data-export]")) {
            const what = link.getAttribute("data-export") ?? "";
            const query = what === "recording.mcap" ? "" : what === "animation.gif" ? `?${look}` : `?at=${this.#at}&${look}`;
            const empty = this.#at < 0 && what !== "picture.svg" && what !== "picture.png";
            if (empty) link.removeAttribute("href");
            else link.setAttribute("href", api.sourceAddress(this.#source, what + query));
        }
    }

    #watchPointer() {
        const map = this.#part(".map");
        map.onpointermove = (event) => this.#point(this.#map?.cellAt(event) ?? null);
        map.onpointerleave = () => this.#point(null);
        map.onblur = () => this.#point(null);
        map.onkeydown = (event) => {
            const source = this.#source;
            const heading = ["ArrowUp", "ArrowRight", "ArrowDown", "ArrowLeft"].indexOf(event.key);
            if (heading < 0 || !source) return;
            event.preventDefault();
            event.stopPropagation();
            const from = this.#cell ?? (this.#state ? this.#state.y * source.width + this.#state.x : 0);
            const x = (from % source.width) + [0, 1, 0, -1][heading];
            const y = Math.floor(from / source.width) + [1, 0, -1, 0][heading];
            if (x >= 0 && y >= 0 && x < source.width && y < source.height) this.#point(y * source.width + x);
        };
    }

    /** @param {number | null} cell */
    #point(cell) {
        this.#cell = cell;
        this.#map?.mark(cell);
        this.#readout();
    }

    #readout() {
        const source = this.#source;
        write(
            this.#part(".readout"),
            source && this.#cell !== null
                ? describeCell(this.#cell, source, this.#state)
                : this.timeline.states === 0 && this.#id === "live"
                  ? "Waiting for a mouse: press Run, or connect yours."
                  : "",
        );
    }
}
