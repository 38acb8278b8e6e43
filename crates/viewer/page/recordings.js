// @ts-check
// Recordings: those that the server keeps, and files that a person brings.

import * as api from "./api.js";
import { clearProblem, copy, grouped, part, pause, report, write } from "./dom.js";

/** Milliseconds between looks at what the server keeps: a client may reset as often as it likes. */
const LIST_PAUSE = 1000;
/** What the server names a recording: the time, the maze, a number. */
const NAME = /^[\d-]+_[\d-]+_(.+)_\d+$/;

export class RecordingList {
  #element = part(document, "#recordings");
  #show;
  /** What is listed, by name. @type {Map<string, HTMLElement>} */
  #items = new Map();
  #isStale = false;
  #listing = false;

  /** @param {(id: string) => void} show */
  constructor(show) {
    this.#show = show;
    const input = part(this.#element, "[name=file]", HTMLInputElement);
    input.onchange = () => {
      this.#load(input.files);
      input.value = "";
    };
    const { body } = document;
    /** @param {boolean} dropping */
    const mark = (dropping) => body.classList.toggle("dropping", dropping);
    body.ondragover = (event) => {
      event.preventDefault();
      mark(true);
    };
    body.ondragleave = (event) => mark(event.relatedTarget !== null);
    body.ondrop = (event) => {
      event.preventDefault();
      mark(false);
      this.#load(event.dataTransfer?.files);
    };
  }

  /** Lists what the server keeps, one look after the other. */
  async list() {
    this.#isStale = true;
    if (this.#listing) return;
    this.#listing = true;
    while (this.#isStale) {
      this.#isStale = false;
      await api.recordings().then((entries) => this.#list(entries), report);
      await pause(LIST_PAUSE);
    }
    this.#listing = false;
  }

  /** What stays in the list is not touched, since it may have the focus. @param {api.RecordingEntry[]} entries */
  #list(entries) {
    const list = part(this.#element, "ul");
    part(this.#element, ".none").hidden = entries.length > 0;
    const names = new Set(entries.map(({ name }) => name));
    for (const [name, item] of this.#items) {
      if (names.has(name)) continue;
      item.remove();
      this.#items.delete(name);
    }
    entries.forEach(({ name, bytes, modified }, i) => {
      const item = this.#items.get(name) ?? this.#item(name);
      write(item, ".size", `${grouped(Math.ceil(bytes / 1000))} kB`);
      write(item, ".when", new Date(modified).toLocaleString());
      if (list.children[i] !== item) list.insertBefore(item, list.children[i] ?? null);
    });
  }

  /** @param {string} name */
  #item(name) {
    const item = copy("recording");
    const button = part(item, "button", HTMLButtonElement);
    const stem = name.replace(/\.mcap$/, "");
    write(item, ".name", NAME.exec(stem)?.[1] ?? stem);
    button.title = name;
    button.onclick = () => {
      clearProblem();
      this.#open(api.openRecording(name));
    };
    this.#items.set(name, item);
    return item;
  }

  /** @param {FileList | null | undefined} files */
  async #load(files) {
    clearProblem();
    // One after the other, since the server receives few at the same time. The list empties with its field.
    for (const file of [...(files ?? [])]) await this.#open(api.loadRecording(file));
  }

  /** @param {Promise<string>} opening */
  #open(opening) {
    return opening.then(this.#show).catch(report);
  }
}
