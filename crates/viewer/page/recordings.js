// @ts-check
// The list of the server's recordings, and the upload of recordings and mazes from the user's files.

import * as api from "./api.js";
import { clearError, cloneTemplate, formatNumber, oneAtATime, query, setText, showError, sleep } from "./dom.js";

/** Minimum time between requests for the list, in milliseconds. Clients may reset more often. */
const REFRESH_PAUSE = 1000;
/** The first bytes of a recording, decoded as UTF-8. */
const MAGIC = "\ufffdMCAP0\r\n";
/** Names of the server's recordings, which consist of date, time, maze and number. */
const NAME = /^[\d-]+_[\d-]+_(.+)_\d+$/;

export class RecordingList {
  #element = query(document, "#recordings");
  #onOpen;
  #openMaze;
  /** List items by name. @type {Map<string, HTMLElement>} */
  #items = new Map();
  /** Uploads follow one another, since the server limits parallel ones, and each may ask the user. */
  #uploads = Promise.resolve();

  /** @param {(id: string) => void} onOpen @param {(file: File) => Promise<void>} openMaze */
  constructor(onOpen, openMaze) {
    this.#onOpen = onOpen;
    this.#openMaze = openMaze;
    const input = query(this.#element, "[name=file]", HTMLInputElement);
    input.onchange = () => {
      this.#upload(input.files);
      input.value = "";
    };
    const { body } = document;
    /** @param {boolean} dragging */
    const highlight = (dragging) => body.classList.toggle("dropping", dragging);
    // The section is inert while the server cannot be reached.
    const canOpen = () => !this.#element.inert;
    body.ondragover = (event) => {
      event.preventDefault();
      if (event.dataTransfer && !canOpen()) event.dataTransfer.dropEffect = "none";
      highlight(canOpen());
    };
    body.ondragleave = (event) => highlight(event.relatedTarget !== null);
    body.ondrop = (event) => {
      event.preventDefault();
      highlight(false);
      if (canOpen()) this.#upload(event.dataTransfer?.files);
    };
  }

  refresh = oneAtATime(async () => {
    await api.recordings().then((entries) => this.#show(entries), showError);
    await sleep(REFRESH_PAUSE);
  });

  /** Updates the list but keeps existing items, since one may have the focus. @param {api.RecordingEntry[]} entries */
  #show(entries) {
    const list = query(this.#element, "ul");
    query(this.#element, ".empty").hidden = entries.length > 0;
    const names = new Set(entries.map(({ name }) => name));
    for (const [name, item] of this.#items) {
      if (names.has(name)) continue;
      item.remove();
      this.#items.delete(name);
    }
    entries.forEach(({ name, bytes, modified }, i) => {
      const item = this.#items.get(name) ?? this.#addItem(name);
      setText(item, ".size", `${formatNumber(Math.ceil(bytes / 1000))} kB`);
      setText(item, ".when", new Date(modified).toLocaleString());
      if (list.children[i] !== item) list.insertBefore(item, list.children[i] ?? null);
    });
  }

  /** @param {string} name */
  #addItem(name) {
    const item = cloneTemplate("recording");
    const button = query(item, "button", HTMLButtonElement);
    const stem = name.replace(/\.mcap$/, "");
    setText(item, ".name", NAME.exec(stem)?.[1] ?? stem);
    button.title = name;
    button.onclick = () => {
      clearError();
      api.openRecording(name).then(this.#onOpen).catch(showError);
    };
    this.#items.set(name, item);
    return item;
  }

  /** @param {FileList | null | undefined} files */
  #upload(files) {
    clearError();
    // Copy the list of files, since clearing the input empties the list.
    for (const file of [...(files ?? [])]) this.#uploads = this.#uploads.then(() => this.#uploadFile(file)).catch(showError);
  }

  /** @param {File} file */
  async #uploadFile(file) {
    const isRecording = file.name.endsWith(".mcap") || (await file.slice(0, MAGIC.length).text()) === MAGIC;
    if (isRecording) this.#onOpen(await api.uploadRecording(file));
    else await this.#openMaze(file);
  }
}
