// @ts-check
// The list of mazes, which can be searched and sorted. Thumbnails load as they scroll into view; a click on an entry loads the maze.

import * as api from "./api.js";
import { clearError, cloneTemplate, listStep, pluralize, query, setText, showError } from "./dom.js";

/**
 * @typedef {{ maze: api.MazeEntry, kind: string, folder: string, searchText: string, item: HTMLElement,
 *   button: HTMLButtonElement }} Entry
 */

const { compare } = new Intl.Collator("en", { numeric: true });

/**
 * The orders of the list. Within equal entries and within groups, mazes are sorted by name.
 * @type {Record<string, { key: (entry: Entry) => number, group: (entry: Entry) => string }>}
 */
const ORDERS = {
  folder: { key: () => 0, group: ({ folder }) => folder },
  name: { key: () => 0, group: () => "" },
  size: { key: ({ maze }) => Number(maze.width) * Number(maze.height), group: ({ maze }) => size(maze) },
  path: { key: ({ maze }) => maze.shortest_path ?? 0, group: () => "" },
};

/** The kinds of mazes in the order of the list, each with the heading of its group, if it has one of its own. */
const KINDS = { solvable: "", unsolvable: "Goal unreachable", unreadable: "Unreadable" };

/** @param {Pick<api.MazeEntry, "width" | "height">} maze */
const size = ({ width, height }) => `${width} × ${height}`;

export class MazeList {
  #element = query(document, "#mazes");
  #list = query(this.#element, "ul");
  #search = query(this.#element, "input", HTMLInputElement);
  #sort = query(this.#element, "[name=sort]", HTMLSelectElement);
  /** All mazes in the order of the list. @type {Entry[]} */
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
    this.#sort.onchange = () => this.#arrange();
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
    if (this.#entries.every(({ folder }) => !folder)) query(this.#sort, "[value=folder]").remove();
    this.#arrange();
  }

  /** Sorts and groups the mazes. Mazes without a solution come last. */
  #arrange() {
    const { key, group } = ORDERS[this.#sort.value];
    const kinds = Object.keys(KINDS);
    const groupName = (/** @type {Entry} */ entry) => KINDS[/** @type {keyof KINDS} */ (entry.kind)] || group(entry);
    this.#entries.sort(
      (a, b) =>
        kinds.indexOf(a.kind) - kinds.indexOf(b.kind) ||
        key(a) - key(b) ||
        compare(group(a), group(b)) ||
        compare(a.maze.maze, b.maze.maze),
    );
    const groups = Map.groupBy(this.#entries, groupName);
    const lists = [...groups].map(([name, entries]) => {
      const element = cloneTemplate("maze-group");
      setText(element, "h3", name).hidden = groups.size === 1 || !name;
      query(element, "ul").append(...entries.map(({ item }) => item));
      return element;
    });
    this.#list.replaceChildren(...lists);
    this.#element.dataset.sort = this.#sort.value;
    this.#filter();
    this.#showCurrent();
  }

  /** @param {api.MazeEntry} maze @param {string} relativePath @returns {Entry} */
  #entry(maze, relativePath) {
    const { path, maze: name, error, shortest_path: steps } = maze;
    const item = cloneTemplate("maze");
    const button = query(item, "button", HTMLButtonElement);
    const kind = error !== null ? "unreadable" : steps === null ? "unsolvable" : "solvable";
    const folder = relativePath.replace(/[^/\\]*$/, "").slice(0, -1);
    const shortestPath = error ?? (steps === null ? kind : pluralize(steps, "step"));
    setText(item, ".name", name);
    setText(item, ".size", error === null ? size(maze) : kind);
    setText(item, ".path", shortestPath);
    setText(item, ".folder", folder);
    item.dataset.path = path;
    item.dataset.kind = kind;
    button.title = error ?? relativePath;
    button.onclick = () => this.#select(maze);
    if (error === null) {
      const thumbnail = query(item, "img", HTMLImageElement);
      thumbnail.dataset.path = path;
      this.#thumbnails.observe(thumbnail);
    }
    const searchText = `${relativePath} ${name} ${maze.width}x${maze.height} ${shortestPath}`.toLowerCase();
    return { maze, kind, folder, item, button, searchText };
  }

  /** Shows the mazes that match all search words, in any order and ignoring case. */
  #filter() {
    const words = this.#search.value.toLowerCase().split(/\s+/);
    for (const { searchText, item } of this.#entries) item.hidden = !words.every((word) => searchText.includes(word));
    for (const group of this.#list.children) {
      if (group instanceof HTMLElement) group.hidden = group.querySelector("li:not([hidden])") === null;
    }
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
    const step = listStep(key);
    if (step === undefined || (searching && key !== "ArrowDown")) return;
    event.preventDefault();
    const i = shown.findIndex(({ button }) => button === target);
    if (i === 0 && step < 0) return this.#search.focus();
    const next = shown[Math.max(0, Math.min(i + step, shown.length - 1))]?.button;
    next?.focus();
    this.#setTabStop(next);
  }

  /** Loads a maze, after confirmation if loading deletes states or stops a mouse. @param {api.MazeEntry} maze */
  async #select({ path, maze: name, error }) {
    clearError();
    if (error !== null) return showError(new Error(error));
    const confirmed = await this.#confirm(name);
    if (confirmed) await api.loadMaze({ path }, confirmed === "run").catch(showError);
  }

  /** Loads the maze in a file of the user, who chooses between its readings. @param {File} file */
  async open(file) {
    const { maze: name, readings } = await api.readMaze(file);
    const reading = readings.length === 1 ? readings[0] : await chooseReading(name, readings);
    const confirmed = reading && (await this.#confirm(name));
    if (reading && confirmed) await api.loadMaze({ maze: name, drawing: reading.drawing }, confirmed === "run");
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
      const offset = item.getBoundingClientRect().top - this.#list.getBoundingClientRect().top;
      if (current) this.#list.scrollTop += offset - 60;
    }
    this.#setTabStop(document.activeElement);
  }
}

/**
 * Asks which of several mazes a file contains. Returns undefined if the user chooses none.
 * @param {string} name @param {api.MazeReading[]} readings @returns {Promise<api.MazeReading | undefined>}
 */
function chooseReading(name, readings) {
  const dialog = query(document, "#readings", HTMLDialogElement);
  setText(dialog, ".name", name);
  const items = readings.map(({ options, picture, shortest_path: steps, ...maze }, i) => {
    const item = cloneTemplate("reading");
    query(item, "button", HTMLButtonElement).value = `${i}`;
    query(item, "img", HTMLImageElement).src = `data:image/svg+xml,${encodeURIComponent(picture)}`;
    setText(item, ".name", options);
    setText(item, ".facts", `${size(maze)}, ${steps === null ? "goal unreachable" : pluralize(steps, "step")}`);
    return item;
  });
  query(dialog, "ul").replaceChildren(...items);
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue ? readings[Number(dialog.returnValue)] : undefined);
  });
}

/** @param {string[]} paths */
function commonFolderLength([first = "", ...others]) {
  let folder = first;
  do folder = folder.replace(/[^/\\]*[/\\]?$/, "");
  while (!others.every((path) => path.startsWith(folder)));
  return folder.length;
}
