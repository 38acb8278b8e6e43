// @ts-check
// The searchable list of mazes. Thumbnails load as they scroll into view; a click on an entry loads the maze.

import * as api from "./api.js";
import { clearError, cloneTemplate, pluralize, query, setText, showError } from "./dom.js";

export class MazeList {
  #element = query(document, "#mazes");
  #list = query(this.#element, "ul");
  #search = query(this.#element, "input", HTMLInputElement);
  /** @type {{ maze: api.MazeEntry, searchText: string, item: HTMLElement, button: HTMLButtonElement }[]} */
  #entries = [];
  #confirm;
  /** @type {string | null} */
  #current = null;
  #thumbnails = new IntersectionObserver(
    (changes) => {
      for (const { isIntersecting, target } of changes) {
        if (!isIntersecting || !(target instanceof HTMLImageElement)) continue;
        target.src = api.thumbnailUrl(target.dataset.path ?? "");
        this.#thumbnails.unobserve(target);
      }
    },
    { root: this.#list, rootMargin: "60px" },
  );

  /** @param {(maze: string) => Promise<"" | "confirm" | "run">} confirm */
  constructor(confirm) {
    this.#confirm = confirm;
    this.#element.hidden = false;
    this.#search.oninput = () => this.#filter();
    this.#element.onkeydown = (event) => this.#handleKey(event);
  }

  /** Focuses the search field and selects the text, so that typing replaces the text. */
  focusSearch() {
    this.#search.focus();
    this.#search.select();
  }

  async load() {
    const mazes = await api.mazes();
    const prefix = commonFolderLength(mazes.map(({ path }) => path));
    this.#entries = mazes.map((maze) => this.#entry(maze, maze.path.slice(prefix)));
    this.#list.replaceChildren(...this.#entries.map(({ item }) => item));
    this.#filter();
    this.#showCurrent();
  }

  /** @param {api.MazeEntry} maze @param {string} relativePath */
  #entry(maze, relativePath) {
    const { path, name, width, height, error, shortest_path: steps } = maze;
    const item = cloneTemplate("maze");
    const button = query(item, "button", HTMLButtonElement);
    const kind = error !== null ? "unreadable" : steps === null ? "unsolvable" : "solvable";
    const size = error === null ? `${width} × ${height}` : kind;
    const shortestPath = error ?? (steps === null ? kind : pluralize(steps, "step"));
    setText(item, ".name", name);
    setText(item, ".size", size);
    setText(item, ".path", shortestPath);
    item.dataset.path = path;
    item.dataset.kind = kind;
    button.title = error ?? relativePath;
    button.onclick = () => this.#select(maze);
    if (error === null) {
      const thumbnail = query(item, "img", HTMLImageElement);
      thumbnail.dataset.path = path;
      this.#thumbnails.observe(thumbnail);
    }
    const searchText = `${relativePath} ${name} ${width}x${height} ${shortestPath}`.toLowerCase();
    return { maze, item, button, searchText };
  }

  /** Shows the mazes that match all search words, in any order and ignoring case. */
  #filter() {
    const words = this.#search.value.toLowerCase().split(/\s+/);
    for (const { searchText, item } of this.#entries) item.hidden = !words.every((word) => searchText.includes(word));
    const [shown, total] = [this.#shown.length, this.#entries.length];
    setText(this.#element, ".count", shown === total ? total : `${shown} of ${total}`);
    this.#setTabStop();
  }

  get #shown() {
    return this.#entries.filter(({ item }) => !item.hidden);
  }

  /** Makes one maze reachable with Tab: the preferred, the current or the first maze. @param {unknown} [preferred] */
  #setTabStop(preferred) {
    const shown = this.#shown;
    const current = shown.find(({ maze }) => maze.path === this.#current) ?? shown[0];
    const stop = shown.find(({ button }) => button === preferred) ?? current;
    for (const entry of this.#entries) entry.button.tabIndex = entry === stop ? 0 : -1;
  }

  /** @param {KeyboardEvent} event */
  #handleKey(event) {
    const shown = this.#shown;
    const { key, target } = event;
    const searching = target === this.#search;
    if (searching && key === "Enter") {
      event.preventDefault(); // otherwise the key would also press a button of the dialog
      if (shown.length > 0 && this.#search.value.trim()) void this.#select(shown[0].maze);
    }
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity }[key];
    if (step === undefined || (searching && key !== "ArrowDown")) return;
    event.preventDefault();
    const i = shown.findIndex(({ button }) => button === target);
    if (i === 0 && step < 0) return this.#search.focus();
    const next = shown[Math.max(0, Math.min(i + step, shown.length - 1))]?.button;
    next?.focus();
    this.#setTabStop(next);
  }

  /** Loads a maze, after confirmation if loading deletes states or stops a mouse. @param {api.MazeEntry} maze */
  async #select({ path, name, error }) {
    clearError();
    if (error !== null) return showError(new Error(error));
    const confirmed = await this.#confirm(name);
    if (confirmed) await api.loadMaze(path, confirmed === "run").catch(showError);
  }

  /** @param {string | null} path */
  setCurrent(path) {
    if (path === this.#current) return;
    this.#current = path;
    this.#showCurrent();
  }

  #showCurrent() {
    for (const { maze, item, button } of this.#entries) {
      const current = maze.path === this.#current;
      button.ariaCurrent = current ? "true" : null;
      if (current) this.#list.scrollTop = item.offsetTop - this.#list.offsetTop - 60;
    }
    this.#setTabStop(document.activeElement);
  }
}

/** @param {string[]} paths */
function commonFolderLength([first = "", ...others]) {
  let folder = first;
  do folder = folder.replace(/[^/\\]*[/\\]?$/, "");
  while (!others.every((path) => path.startsWith(folder)));
  return folder.length;
}
