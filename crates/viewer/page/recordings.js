// @ts-check
// Recordings: those the server keeps, those a person brings; each opens beside the live one.

import * as api from "./api.js";
import { clearProblem, copy, part, report, write } from "./dom.js";

export class RecordingList {
    #element = part(document, "#recordings", HTMLElement);
    #list = part(this.#element, "ul", HTMLElement);
    #opened;

    /** @param {(id: string) => void} opened */
    constructor(opened) {
        this.#opened = opened;
        const input = part(this.#element, "[name=file]", HTMLInputElement);
        input.onchange = () => {
            for (const file of input.files ?? []) this.#open(api.loadRecording(file));
            input.value = "";
        };
        this.#takeDrops();
    }

    /** @param {boolean} kept whether the server keeps recordings */
    async load(kept) {
        const entries = kept ? await api.recordings() : [];
        part(this.#element, ".none", HTMLElement).hidden = entries.length > 0;
        this.#list.replaceChildren(...entries.map((entry) => this.#item(entry)));
    }

    /** @param {api.RecordingEntry} entry */
    #item({ name, bytes, modified }) {
        const item = copy("recording");
        const button = part(item, "button", HTMLButtonElement);
        write(part(item, ".name", HTMLElement), name.replace(/\.mcap$/, ""));
        write(part(item, ".size", HTMLElement), `${(bytes / 1000).toLocaleString("en", { maximumFractionDigits: 0 })} kB`);
        write(part(item, ".when", HTMLElement), new Date(modified).toLocaleString());
        button.title = name;
        button.onclick = () => this.#open(api.openRecording(name));
        return item;
    }

    /** @param {Promise<string>} opening */
    #open(opening) {
        clearProblem();
        opening.then(this.#opened, report);
    }

    #takeDrops() {
        const { body } = document;
        body.ondragover = (event) => {
            event.preventDefault();
            body.classList.add("dropping");
        };
        body.ondragleave = (event) => {
            if (!event.relatedTarget) body.classList.remove("dropping");
        };
        body.ondrop = (event) => {
            event.preventDefault();
            body.classList.remove("dropping");
            for (const file of event.dataTransfer?.files ?? []) this.#open(api.loadRecording(file));
        };
    }
}
