// @ts-check
// The log of the mouse up to the shown state. A filter searches the log of the whole run.

import * as api from "./api.js";
import { formatNumber, query, setText, showError, sleep } from "./dom.js";

/** Minimum time between requests, in milliseconds. */
const PAUSE = 80;

export class LogPane {
  #element;
  #filter;
  #list;
  #seek;
  /** @type {{ source: api.Source, index: number, states: number, signal: AbortSignal } | null} */
  #wanted = null;
  #loading = false;
  /** The shown lines. @type {[number, string][]} */
  #lines = [];
  #shownText = "";

  /** @param {HTMLElement} panel @param {(index: number) => void} seek */
  constructor(panel, seek) {
    this.#element = query(panel, ".log");
    this.#filter = query(this.#element, "input", HTMLInputElement);
    this.#list = query(this.#element, "ol");
    this.#seek = seek;
    this.#filter.oninput = () => void this.#load();
    this.#filter.onkeydown = (event) => {
      if (event.key === "Enter") this.#jump(event.shiftKey);
    };
    this.#list.onkeydown = (event) => this.#handleKey(event);
  }

  /** True if the run has log lines. */
  get isShown() {
    return !this.#element.hidden;
  }

  /** Forgets the lines of the previous run. */
  clear() {
    this.#wanted = null;
    this.#element.hidden = true;
    this.#filter.value = "";
    this.#render([]);
  }

  /** Shows the lines up to a state. @param {api.Source} source @param {number} index @param {number} states @param {AbortSignal} signal */
  show(source, index, states, signal) {
    this.#wanted = { source, index, states, signal };
    void this.#load();
  }

  /** Loads the wanted lines. If others are wanted in the meantime, loads those next. */
  async #load() {
    if (this.#loading) return;
    this.#loading = true;
    for (let loaded = ""; ; ) {
      const wanted = this.#wanted;
      const filter = this.#filter.value.trim();
      const last = wanted && (filter ? wanted.states - 1 : wanted.index);
      const key = wanted && `${wanted.source.run} ${last} ${filter}`;
      if (!wanted || last === null || last < 0 || key === null || key === loaded) break;
      const lines = await api.log(wanted.source, last, filter, wanted.signal).catch(showLogError);
      if (this.#wanted?.source === wanted.source && lines) {
        if (lines.length > 0) this.#element.hidden = false;
        this.#render(lines);
      }
      loaded = key;
      await sleep(PAUSE);
    }
    this.#loading = false;
    this.#highlight();
  }

  /** @param {[number, string][]} lines */
  #render(lines) {
    const text = JSON.stringify(lines);
    if (text !== this.#shownText) {
      this.#shownText = text;
      this.#lines = lines;
      const focused = this.#list.contains(document.activeElement);
      this.#list.replaceChildren(
        ...lines.map(([state, line]) => {
          const item = document.createElement("li");
          const button = document.createElement("button");
          const [number, content] = [document.createElement("small"), document.createElement("span")];
          number.textContent = formatNumber(state + 1);
          content.textContent = line;
          button.append(number, content);
          button.onclick = () => this.#seek(state);
          item.append(button);
          return item;
        }),
      );
      if (focused) this.#list.querySelector("button")?.focus();
    }
    setText(this.#element, ".empty", this.#filter.value && lines.length === 0 ? "No line matches." : "");
    this.#highlight();
  }

  /** Highlights the lines of the newest shown state that has some. */
  #highlight() {
    const index = this.#wanted?.index ?? -1;
    const states = this.#lines.map(([state]) => state);
    const newest = states.filter((state) => state <= index).at(-1) ?? -1;
    const stop = Math.max(0, states.lastIndexOf(newest));
    this.#buttons.forEach((button, i) => {
      const [state] = this.#lines[i];
      button.ariaCurrent = state === newest ? "true" : null;
      button.classList.toggle("later", state > index);
      button.tabIndex = i === stop ? 0 : -1;
    });
    const button = this.#buttons[stop];
    if (!button || this.#list.contains(document.activeElement)) return;
    const [line, list] = [button.getBoundingClientRect(), this.#list.getBoundingClientRect()];
    if (line.top < list.top) this.#list.scrollTop += line.top - list.top;
    else if (line.bottom > list.bottom) this.#list.scrollTop += line.bottom - list.bottom;
  }

  get #buttons() {
    return [...this.#list.querySelectorAll("button")];
  }

  /** Shows the state of the previous or next line, or starts again at the other end. @param {boolean} forward */
  #jump(forward) {
    const index = this.#wanted?.index ?? 0;
    const lines = this.#lines;
    const line = forward
      ? (lines.find(([state]) => state > index) ?? lines[0])
      : (lines.filter(([state]) => state < index).at(-1) ?? lines.at(-1));
    if (line) this.#seek(line[0]);
  }

  /** @param {KeyboardEvent} event */
  #handleKey(event) {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity }[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const buttons = this.#buttons;
    const i = buttons.findIndex((button) => button === document.activeElement);
    buttons[Math.max(0, Math.min(i + step, buttons.length - 1))]?.focus();
  }
}

/** @param {unknown} error */
function showLogError(error) {
  // The next event loads the new run.
  if (!(error instanceof api.ApiError && error.isRunOver)) showError(error);
  return null;
}
