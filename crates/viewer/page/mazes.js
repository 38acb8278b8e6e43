// @ts-check
// The list of mazes: search as you type, pictures as they come into sight, one is served.

import * as api from "./api.js";
import { clearProblem, copy, part, report, write } from "./dom.js";

export class MazeList {
    #element = part(document, "#mazes", HTMLElement);
    #list = part(this.#element, "ul", HTMLElement);
    #search = part(this.#element, "[name=search]", HTMLInputElement);
    /** @type {{ maze: api.MazeEntry, words: string, item: HTMLElement, button: HTMLButtonElement }[]} */
    #entries = [];
    #states;
    /** @type {string | null} */
    #served = null;
    /** Pictures are fetched as they are about to be seen. */
    #pictures = new IntersectionObserver(
        (changes) => {
            for (const { isIntersecting, target } of changes) {
                if (!isIntersecting || !(target instanceof HTMLImageElement)) continue;
                target.src = api.mazePicture(target.dataset.path ?? "");
                this.#pictures.unobserve(target);
            }
        },
        { root: this.#list, rootMargin: "60px" },
    );

    /** @param {() => number} states how many there are to lose */
    constructor(states) {
        this.#states = states;
        this.#element.hidden = false;
        this.#search.oninput = () => this.#filter();
        this.#element.onkeydown = (event) => this.#press(event);
    }

    async load() {
        const mazes = await api.mazes();
        this.#pictures.disconnect();
        this.#entries = mazes.map((maze) => this.#entry(maze));
        this.#list.replaceChildren(...this.#entries.map(({ item }) => item));
        this.#filter();
        this.mark(this.#served);
    }

    /** @param {api.MazeEntry} maze */
    #entry(maze) {
        const item = copy("maze");
        const button = part(item, "button", HTMLButtonElement);
        const size = maze.width === null ? "" : `${maze.width} × ${maze.height}`;
        const way = maze.shortest_path === null ? "unsolvable" : `path ${maze.shortest_path}`;
        const picture = part(item, "img", HTMLImageElement);
        write(part(item, ".name", HTMLElement), maze.name);
        write(part(item, ".size", HTMLElement), maze.error ?? size);
        write(part(item, ".way", HTMLElement), maze.error === null ? way : "unreadable");
        item.dataset.path = maze.path;
        item.dataset.kind = maze.error !== null ? "unreadable" : maze.shortest_path === null ? "unsolvable" : "solvable";
        if (maze.error === null) {
            picture.dataset.path = maze.path;
            this.#pictures.observe(picture);
        }
        button.title = maze.error ?? maze.path;
        button.setAttribute("aria-disabled", String(maze.error !== null));
        button.onclick = () => this.#choose(maze);
        const words = `${maze.path} ${maze.name} ${maze.width}x${maze.height} ${size} ${way}`.toLowerCase();
        return { maze, words, item, button };
    }

    /** Shows the mazes that have all words, in any order and case. */
    #filter() {
        const wanted = this.#search.value.toLowerCase().split(/\s+/);
        for (const { words, item } of this.#entries) item.hidden = !wanted.every((word) => words.includes(word));
        const count = this.#shown.length;
        const all = this.#entries.length;
        write(part(this.#element, ".count", HTMLElement), count === all ? String(all) : `${count} of ${all}`);
        this.#stop();
    }

    get #shown() {
        return this.#entries.filter(({ item }) => !item.hidden);
    }

    /** One maze of the list is reached by Tab: the one in focus, the served one or the first. */
    #stop(chosen = document.activeElement) {
        const shown = this.#shown;
        const stop =
            shown.find(({ button }) => button === chosen) ??
            shown.find(({ maze }) => maze.path === this.#served) ??
            shown[0];
        for (const entry of this.#entries) entry.button.tabIndex = entry === stop ? 0 : -1;
    }

    /** @param {KeyboardEvent} event */
    #press(event) {
        const shown = this.#shown;
        const at = shown.findIndex(({ button }) => button === event.target);
        const searching = event.target === this.#search;
        if (searching && event.key === "Enter" && shown.length > 0) void this.#choose(shown[0].maze);
        const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity }[event.key];
        if (step === undefined || (searching && event.key !== "ArrowDown")) return;
        event.preventDefault();
        event.stopPropagation();
        if (at === 0 && step < 0) return this.#search.focus();
        const next = shown[Math.max(0, Math.min(at + step, shown.length - 1))]?.button;
        if (!next) return;
        next.focus();
        this.#stop(next);
    }

    /** Serves a maze, after asking if that deletes states. @param {api.MazeEntry} maze */
    async #choose(maze) {
        if (maze.error !== null) return report(new Error(maze.error));
        const states = this.#states();
        if (states > 0 && !(await confirmed(maze.name, states))) return;
        clearProblem();
        await api.serveMaze(maze.path).catch(report);
    }

    /** @param {string | null} served its path */
    mark(served) {
        const fresh = served !== this.#served;
        this.#served = served;
        for (const { maze, item, button } of this.#entries) {
            const current = maze.path === served;
            button.toggleAttribute("aria-current", current);
            if (current) button.setAttribute("aria-current", "true");
            if (current && fresh) item.scrollIntoView({ block: "nearest" });
        }
        this.#stop();
    }
}

/** @param {string} name @param {number} states @returns {Promise<boolean>} */
function confirmed(name, states) {
    const dialog = part(document, "#confirm", HTMLDialogElement);
    write(part(dialog, ".name", HTMLElement), name);
    write(part(dialog, ".states", HTMLElement), states === 1 ? "1 state" : `${states.toLocaleString("en")} states`);
    dialog.returnValue = "";
    dialog.showModal();
    return new Promise((resolve) => {
        dialog.onclose = () => resolve(dialog.returnValue === "serve");
    });
}
