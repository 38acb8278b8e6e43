// @ts-check
// The list of mazes: search as you type, pictures as they come into sight, one is served.

import * as api from "./api.js";
import { clearProblem, confirmed, copy, part, report, write } from "./dom.js";

export class MazeList {
  #element = part(document, "#mazes");
  #list = part(this.#element, "ul");
  #search = part(this.#element, "input", HTMLInputElement);
  /** @type {{ maze: api.MazeEntry, words: string, item: HTMLElement, button: HTMLButtonElement }[]} */
  #entries = [];
  #states;
  /** @type {string | null} */
  #served = null;
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

  /** What is typed next replaces what was searched for. */
  search() {
    this.#search.focus();
    this.#search.select();
  }

  async load() {
    const mazes = await api.mazes();
    const shared = sharedFolder(mazes.map(({ path }) => path));
    this.#entries = mazes.map((maze) => this.#entry(maze, maze.path.slice(shared)));
    this.#list.replaceChildren(...this.#entries.map(({ item }) => item));
    this.#filter();
    this.#mark();
  }

  /** @param {api.MazeEntry} maze @param {string} place its path in the collection */
  #entry(maze, place) {
    const { path, name, width, height, error } = maze;
    const item = copy("maze");
    const button = part(item, "button", HTMLButtonElement);
    const solvable = maze.shortest_path !== null;
    const size = error === null ? `${width} × ${height}` : "unreadable";
    const way = error ?? (solvable ? `path ${maze.shortest_path}` : "unsolvable");
    write(item, ".name", name);
    write(item, ".size", size);
    write(item, ".way", way);
    item.dataset.path = path;
    item.dataset.kind = error !== null ? "unreadable" : solvable ? "solvable" : "unsolvable";
    button.title = error ?? place;
    button.onclick = () => this.#choose(maze);
    if (error === null) {
      const picture = part(item, "img", HTMLImageElement);
      picture.dataset.path = path;
      this.#pictures.observe(picture);
    }
    return { maze, item, button, words: `${place} ${name} ${width}x${height} ${way}`.toLowerCase() };
  }

  /** Shows the mazes that have all words, in any order and case. */
  #filter() {
    const wanted = this.#search.value.toLowerCase().split(/\s+/);
    for (const { words, item } of this.#entries) item.hidden = !wanted.every((word) => words.includes(word));
    const [shown, all] = [this.#shown.length, this.#entries.length];
    write(this.#element, ".count", shown === all ? all : `${shown} of ${all}`);
    this.#rove();
  }

  get #shown() {
    return this.#entries.filter(({ item }) => !item.hidden);
  }

  /** Tab reaches one maze of the list: the given one, the served one or the first. @param {unknown} [chosen] */
  #rove(chosen) {
    const shown = this.#shown;
    const served = shown.find(({ maze }) => maze.path === this.#served) ?? shown[0];
    const stop = shown.find(({ button }) => button === chosen) ?? served;
    for (const entry of this.#entries) entry.button.tabIndex = entry === stop ? 0 : -1;
  }

  /** @param {KeyboardEvent} event */
  #press(event) {
    const shown = this.#shown;
    const { key, target } = event;
    const searching = target === this.#search;
    if (searching && key === "Enter") {
      event.preventDefault(); // or it would go on to a button of the dialog
      if (shown.length > 0 && this.#search.value.trim()) void this.#choose(shown[0].maze);
    }
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity }[key];
    if (step === undefined || (searching && key !== "ArrowDown")) return;
    event.preventDefault();
    const at = shown.findIndex(({ button }) => button === target);
    if (at === 0 && step < 0) return this.#search.focus();
    const next = shown[Math.max(0, Math.min(at + step, shown.length - 1))]?.button;
    next?.focus();
    this.#rove(next);
  }

  /** Serves a maze, after asking if that deletes states. @param {api.MazeEntry} maze */
  async #choose({ path, name, error }) {
    clearProblem();
    if (error !== null) return report(new Error(error));
    const states = this.#states();
    if (states > 0 && !(await confirmed("Serve", name, states))) return;
    await api.serveMaze(path).catch(report);
  }

  /** @param {string | null} served its path */
  mark(served) {
    if (served === this.#served) return;
    this.#served = served;
    this.#mark();
  }

  #mark() {
    for (const { maze, item, button } of this.#entries) {
      const current = maze.path === this.#served;
      button.ariaCurrent = current ? "true" : null;
      if (current) this.#list.scrollTop = item.offsetTop - this.#list.offsetTop - 60;
    }
    this.#rove(document.activeElement);
  }
}

/** The length of the folders that all paths begin with. @param {string[]} paths */
function sharedFolder([first = "", ...others]) {
  let folder = first;
  do folder = folder.replace(/[^/\\]*[/\\]?$/, "");
  while (!others.every((path) => path.startsWith(folder)));
  return folder.length;
}
