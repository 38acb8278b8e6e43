// @ts-check
// The list of the server's recordings, and the upload of recordings and mazes from the user's files.

import * as api from "./api.js";
import { buttonOf, clearError, cloneTemplate, confirmAction, formatBytes, oneAtATime, query, setText, showError, sleep } from "./dom.js";

/** Minimum time between requests for the list, in milliseconds. Clients may reset more often. */
const REFRESH_PAUSE = 1000;
/** The first bytes of a recording, decoded as UTF-8. */
const MAGIC = "\ufffdMCAP0\r\n";
/** Names of the server's recordings, which consist of date, time, maze and number. */
const NAME = /^[\d-]+_[\d-]+_(.+)_\d+$/;
/** How the list shows the time of a recording. @type {Intl.DateTimeFormatOptions} */
const TIME = { dateStyle: "short", timeStyle: "medium" };

export class RecordingList {
  #element = query(document, "#recordings");
  #onOpen;
  #openMaze;
  /** List items by name. @type {Map<string, HTMLElement>} */
  #items = new Map();
  /** The entries of the list items. @type {WeakMap<Element, api.RecordingEntry>} */
  #entries = new WeakMap();
  /** Summaries follow one another, since the server reads each recording. */
  #summaries = Promise.resolve();
  /** Requests the summaries of the list items that become visible. */
  #visible = new IntersectionObserver((changes) => {
    for (const { isIntersecting, target } of changes) {
      if (!isIntersecting || !(target instanceof HTMLElement)) continue;
      this.#visible.unobserve(target);
      this.#summaries = this.#summaries.then(() => this.#summarize(target));
    }
  });
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
      const neighbour = item.nextElementSibling ?? item.previousElementSibling ?? this.#element;
      if (item.contains(document.activeElement)) query(neighbour, "button, input").focus();
      item.remove();
      this.#items.delete(name);
    }
    entries.forEach((entry, i) => {
      const { name, bytes, modified, being_written } = entry;
      const item = this.#items.get(name) ?? this.#addItem(name);
      const old = this.#entries.get(item);
      this.#entries.set(item, entry);
      setText(item, ".size", formatBytes(bytes));
      setText(item, ".when", new Date(modified).toLocaleString(undefined, TIME));
      for (const action of ["rename", "delete"]) query(item, `[name=${action}]`, HTMLButtonElement).disabled = being_written;
      if (being_written) this.#showSummary(item, null);
      else if (old?.bytes !== bytes || old.modified !== modified || old.being_written) this.#visible.observe(item);
      if (list.children[i] !== item) list.insertBefore(item, list.children[i] ?? null);
    });
  }

  /** @param {HTMLElement} item */
  async #summarize(item) {
    const { name } = this.#entries.get(item) ?? {};
    if (name === undefined || !item.isConnected) return;
    const summary = await api.recordingSummary(name).catch(() => null);
    if (!this.#entries.get(item)?.being_written) this.#showSummary(item, summary);
  }

  /** Shows the names of the mouse and the maze, or the name that the user has given. @param {HTMLElement} item @param {api.RecordingSummary | null} summary */
  #showSummary(item, summary) {
    const { name = "", being_written = false } = this.#entries.get(item) ?? {};
    const stem = name.replace(/\.mcap$/, "");
    const [, maze] = NAME.exec(stem) ?? [];
    const names = [summary?.mouse, summary?.maze ?? maze];
    const result = being_written ? "recording…" : summary?.result;
    /** @param {(string | null | undefined)[]} parts */
    const join = (parts) => parts.filter(Boolean).join(" · ");
    setText(item, ".name", maze === undefined ? stem : join(names));
    setText(item, ".result", join(maze === undefined ? [...names, result] : [result]));
  }

  /** @param {string} name */
  #addItem(name) {
    const item = cloneTemplate("recording");
    /** @param {string} button @param {() => Promise<unknown>} act */
    const onClick = (button, act) =>
      buttonOf(item, button, () => {
        clearError();
        act().catch(showError);
      });
    onClick("open", () => api.openRecording(name).then(this.#onOpen)).title = name;
    onClick("rename", async () => {
      const to = await askName(name.replace(/\.mcap$/, ""));
      if (to) await api.renameRecording(name, to);
    });
    onClick("delete", async () => {
      const warning = `The file ${name} cannot be restored.`;
      if (await confirmAction("Delete", item.querySelector(".name")?.textContent ?? "", 0, { warning })) await api.deleteRecording(name);
    });
    this.#items.set(name, item);
    this.#entries.set(item, { name, bytes: 0, modified: "", being_written: false });
    this.#showSummary(item, null);
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

/** Asks for a new name of a recording. Resolves to an empty string if the user cancels. @param {string} name @returns {Promise<string>} */
function askName(name) {
  const dialog = query(document, "#rename", HTMLDialogElement);
  const input = query(dialog, "input", HTMLInputElement);
  input.value = name;
  buttonOf(dialog, "cancel", () => dialog.close());
  dialog.returnValue = "";
  dialog.showModal();
  input.select();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue && input.value);
  });
}
