// @ts-check
// The log of the mouse up to the shown state. A filter searches the log of the whole run.

import * as api from "./api.js";
import { formatNumber, listStep, query, setText, sleep } from "./dom.js";

/** Minimum time between requests, in milliseconds. */
const PAUSE = 80;
/** The maximum number of lines in a request before and after a state. The pane keeps at most twice as many. */
const MAX_LINES = 200;

/** @type {{ lines: [number, string][], first: number, last: number, hasLater: boolean, filter: string, annotations: number }} */
const NOTHING = { lines: [], first: 0, last: -1, hasLater: false, filter: "", annotations: 0 };

/** @typedef {{ source: api.Source, index: number, states: number, annotations: number, signal: AbortSignal }} Requested */

export class LogPane {
  #element;
  #filter;
  #list;
  #seek;
  /** @type {Requested | null} */
  #requested = null;
  /** @type {Promise<void> | null} */
  #loading = null;
  /** The loaded lines, which are all lines that match the filter from the state `first` to the state `last`. */
  #loaded = { ...NOTHING };
  /** The lines in the list, a part of the loaded lines. @type {[number, string][]} */
  #shown = [];
  /** The state of the highlighted lines. */
  #highlighted = -1;

  /** @param {HTMLElement} panel @param {(index: number) => void} seek */
  constructor(panel, seek) {
    this.#element = query(panel, ".log");
    this.#filter = query(this.#element, "input", HTMLInputElement);
    this.#list = query(this.#element, "ol");
    this.#seek = seek;
    this.#filter.oninput = () => void this.#load();
    this.#filter.onkeydown = (event) => {
      if (event.key === "Enter") void this.#jump(event.shiftKey);
    };
    this.#list.onkeydown = (event) => this.#handleKey(event);
  }

  /** True if the run has log lines. */
  get isShown() {
    return !this.#element.hidden;
  }

  /** Forgets the lines of the previous run. */
  clear() {
    this.#requested = null;
    this.#element.hidden = true;
    this.#filter.value = "";
    this.#loaded = { ...NOTHING };
    this.#render();
  }

  /**
   * Shows the lines up to a state. The lines after the last state change with the number of annotations.
   * @param {api.Source} source @param {number} index @param {number} states @param {number} annotations @param {AbortSignal} signal
   */
  show(source, index, states, annotations, signal) {
    this.#requested = { source, index, states, annotations, signal };
    this.#render();
    void this.#load();
  }

  /** Loads the requested lines. Repeats if the request changes meanwhile. */
  #load() {
    this.#loading ??= this.#loadRequested().finally(() => (this.#loading = null));
    return this.#loading;
  }

  async #loadRequested() {
    for (;;) {
      const requested = this.#requested;
      if (!requested || requested.index < 0) return;
      const { index, states } = requested;
      const { filter, first, last, hasLater, annotations } = this.#loaded;
      const isLoaded = filter === this.#filterText && first <= index && (index <= last || !hasLater);
      const isComplete = last >= states - 1 && annotations === requested.annotations;
      if (isLoaded && (hasLater || isComplete)) return;
      // The new lines of a growing run are added to the loaded lines.
      if (!(await this.#read(requested, isLoaded ? states - 1 : index, isLoaded ? last + 1 : 0))) return;
      await sleep(PAUSE);
    }
  }

  /**
   * Loads the lines around a state, or adds those from the state `from` to the loaded lines. Returns false if this fails.
   * @param {Requested} requested @param {number} at @param {number} from
   */
  async #read({ source, annotations, signal }, at, from) {
    const filter = this.#filterText;
    const range = { at, from, max: MAX_LINES, filter };
    const reply = await api.log(source, range, signal).catch(api.showUnlessOver);
    if (!reply || this.#requested?.source !== source) return false;
    const { lines, first, last, has_later: hasLater } = reply;
    if (filter !== this.#filterText) return true; // the next request replaces the lines
    const isAdded = from > 0 && first === from;
    // A state may have arrived after lines that were the last ones.
    const kept = isAdded ? this.#loaded.lines.filter(([state]) => state < from) : [];
    const loaded = { lines: [...kept, ...lines], first: isAdded ? this.#loaded.first : first, last, hasLater, filter };
    this.#loaded = { ...loaded, annotations };
    const excess = this.#loaded.lines.length - 2 * MAX_LINES;
    if (isAdded && excess > 0) {
      const dropped = this.#loaded.lines.splice(0, excess);
      this.#loaded.first = Math.min(at, dropped[excess - 1][0] + 1);
    }
    if (this.#loaded.lines.length > 0) this.#element.hidden = false;
    this.#render();
    return true;
  }

  /** The loaded lines. Lines after the last state belong to it. @returns {[number, string][]} */
  get #lines() {
    const last = (this.#requested?.states ?? 0) - 1;
    return this.#loaded.lines.map(([state, text]) => [Math.min(state, last), text]);
  }

  get #filterText() {
    return this.#filter.value.trim();
  }

  /** Shows the loaded lines. Without a filter, shows only those up to the shown state. */
  #render() {
    const index = this.#requested?.index ?? -1;
    const { filter, first, hasLater } = this.#loaded;
    const lines = filter ? this.#lines : this.#lines.filter(([state]) => state <= index);
    let same = 0;
    while (same < lines.length && isSame(lines[same], this.#shown[same])) same += 1;
    const hadFocus = this.#list.contains(document.activeElement);
    while (this.#list.children.length > same) this.#list.lastElementChild?.remove();
    this.#list.append(...lines.slice(same).map((line) => this.#item(line)));
    const isUnchanged = same === this.#shown.length && same === lines.length;
    this.#shown = lines;
    setText(this.#element, ".empty", filter && lines.length === 0 ? "No line matches." : "");
    const isPartial = first > 0 || (filter !== "" && hasLater);
    setText(this.#element, ".partial", isPartial ? "Only lines near the shown state are listed." : "");
    this.#highlight(index, isUnchanged, hadFocus && !this.#list.contains(document.activeElement));
  }

  /** @param {[number, string]} line */
  #item([state, line]) {
    const item = document.createElement("li");
    const button = document.createElement("button");
    const [number, content] = [document.createElement("small"), document.createElement("span")];
    number.textContent = formatNumber(state);
    content.textContent = line;
    button.append(number, content);
    button.onclick = () => this.#seek(state);
    item.append(button);
    return item;
  }

  /**
   * Highlights the lines of the newest displayed state with log lines, and scrolls to them if they are others.
   * @param {number} index @param {boolean} isUnchanged @param {boolean} lostFocus
   */
  #highlight(index, isUnchanged, lostFocus) {
    const states = this.#shown.map(([state]) => state);
    const newest = states.filter((state) => state <= index).at(-1) ?? -1;
    if (isUnchanged && newest === this.#highlighted) return;
    this.#highlighted = newest;
    const current = Math.max(0, states.lastIndexOf(newest));
    const buttons = this.#buttons;
    buttons.forEach((button, i) => {
      button.ariaCurrent = states[i] === newest ? "true" : null;
      button.classList.toggle("later", states[i] > index);
      button.tabIndex = i === current ? 0 : -1;
    });
    const button = buttons[current];
    if (lostFocus) button?.focus({ preventScroll: true });
    if (!button) return;
    const [line, list] = [button.getBoundingClientRect(), this.#list.getBoundingClientRect()];
    if (line.top < list.top) this.#list.scrollTop += line.top - list.top;
    else if (line.bottom > list.bottom) this.#list.scrollTop += line.bottom - list.bottom;
  }

  get #buttons() {
    return [...this.#list.querySelectorAll("button")];
  }

  /** Shows the state of the previous or next line, or starts again at the other end. @param {boolean} forward */
  async #jump(forward) {
    await this.#load();
    const requested = this.#requested;
    if (!requested) return;
    const { index, states } = requested;
    /** @returns {[number, string] | undefined} */
    const next = () => {
      const lines = this.#lines;
      return forward ? lines.find(([state]) => state > index) : lines.filter(([state]) => state < index).at(-1);
    };
    const isComplete = () => (forward ? !this.#loaded.hasLater : this.#loaded.first === 0);
    if (!next() && !isComplete()) await this.#read(requested, index, 0);
    let line = next();
    if (!line) {
      const isWhole = this.#loaded.first === 0 && !this.#loaded.hasLater;
      if (!isWhole) await this.#read(requested, forward ? 0 : states - 1, 0);
      line = this.#lines.at(forward ? 0 : -1);
    }
    if (line) this.#seek(line[0]);
  }

  /** @param {KeyboardEvent} event */
  #handleKey(event) {
    const step = listStep(event.key);
    if (step === undefined) return;
    event.preventDefault();
    const buttons = this.#buttons;
    const i = buttons.findIndex((button) => button === document.activeElement);
    buttons[Math.max(0, Math.min(i + step, buttons.length - 1))]?.focus();
  }
}

/** @param {[number, string]} line @param {[number, string] | undefined} other */
const isSame = ([state, text], other) => other !== undefined && state === other[0] && text === other[1];
