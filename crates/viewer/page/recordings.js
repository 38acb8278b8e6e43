// @ts-check
// Recordings: those that the server keeps, and files that a person brings.

import * as api from "./api.js";
import { clearProblem, copy, grouped, part, report, write } from "./dom.js";

export class RecordingList {
  #element = part(document, "#recordings");
  #show;

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

  /** Lists what the server keeps. */
  async list() {
    const entries = await api.recordings();
    part(this.#element, ".none").hidden = entries.length > 0;
    const items = entries.map(({ name, bytes, modified }) => {
      const item = copy("recording");
      const button = part(item, "button", HTMLButtonElement);
      write(item, ".name", name.replace(/\.mcap$/, ""));
      write(item, ".size", `${grouped(Math.ceil(bytes / 1000))} kB`);
      write(item, ".when", new Date(modified).toLocaleString());
      button.title = name;
      button.onclick = () => this.#open(api.openRecording(name));
      return item;
    });
    part(this.#element, "ul").replaceChildren(...items);
  }

  /** @param {FileList | null | undefined} files */
  #load(files) {
    for (const file of files ?? []) this.#open(api.loadRecording(file));
  }

  /** @param {Promise<string>} opening */
  #open(opening) {
    clearProblem();
    opening.then(this.#show).catch(report);
  }
}
