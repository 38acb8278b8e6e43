// @ts-check
// The server's responses for one run, in a document. They show the run without a server: on an exported page, and on any
// page while the server cannot be reached.

import { formatNumber } from "./dom.js";

/** The number of states in a block. */
const BLOCK_STATES = 256;
/** The maximum number of decoded blocks in memory. */
const MAX_BLOCKS = 4;

/** True if this page is exported. */
export const isExported = document.documentElement.classList.contains("exported");

export class EmbeddedRun {
  #document;
  #blocks;
  /** The views in recently used blocks, by the number of the block. @type {Map<number, Promise<any[]>>} */
  #recent = new Map();
  /** The responses by path. @type {Promise<Record<string, string>> | undefined} */
  #responses;
  /** The lines of the log, each with the index of its state. @type {Promise<[number, string][]> | undefined} */
  #log;

  /** @param {Document} document */
  constructor(document) {
    this.#document = document;
    this.#blocks = document.querySelectorAll("[data-embedded=states]");
  }

  /** Returns the response to a request. @param {string} url @returns {Promise<Response>} */
  async respond(url) {
    const { pathname, searchParams } = new URL(url, "http://localhost");
    const resource = pathname.split("/").at(-1);
    if (resource === "moment") return this.#stateView(Number(searchParams.get("at")));
    if (resource === "log") return json(await this.#logLines(searchParams));
    this.#responses ??= this.#decode("responses");
    const path = decodeURIComponent(pathname).replace(/^(\/api\/sources)\/[^/]+/, "$1/1");
    const response = (await this.#responses)[path];
    return response === undefined ? notFound(path) : new Response(response);
  }

  /** @param {number} index */
  async #stateView(index) {
    const number = Math.floor(index / BLOCK_STATES);
    const views = this.#recent.get(number) ?? this.#decodeBlock(number);
    // The most recently used block is the last one.
    this.#recent.delete(number);
    this.#recent.set(number, views);
    if (this.#recent.size > MAX_BLOCKS) this.#recent.delete([...this.#recent.keys()][0]);
    const view = (await views)[index % BLOCK_STATES];
    return view ? json(view) : notFound(`state ${formatNumber(index)}`);
  }

  /** @param {number} number @returns {Promise<any[]>} */
  async #decodeBlock(number) {
    const block = this.#blocks[number];
    /** @type {any[]} */
    const changes = block ? await decode(block) : [];
    /** @type {any} */
    let view = null;
    return changes.map((change) => (view = patch(view, change)));
  }

  /** Selects log lines as the server does. @param {URLSearchParams} query @returns {Promise<import("./api.js").LogLines>} */
  async #logLines(query) {
    const [at, from, max] = ["at", "from", "max"].map((name) => Number(query.get(name)));
    const filter = (query.get("filter") ?? "").toLowerCase();
    this.#log ??= this.#decode("log");
    const lines = (await this.#log).filter(([state, text]) => state >= from && text.toLowerCase().includes(filter));
    const end = lines.findIndex(([state]) => state > at);
    const before = lines.slice(0, end < 0 ? lines.length : end).slice(-max);
    const later = end < 0 ? [] : lines.slice(end, end + max);
    const hasLater = end >= 0 && end + max < lines.length;
    return {
      lines: [...before, ...later],
      // Earlier lines of the first state and later lines of the last state may be missing.
      first: before.length === max ? Math.min(before[0][0] + 1, at) : from,
      last: hasLater ? Math.max(later[later.length - 1][0] - 1, at) : Number.MAX_SAFE_INTEGER,
      has_later: hasLater,
    };
  }

  /** @param {string} name */
  #decode(name) {
    return decode(this.#document.querySelector(`[data-embedded=${name}]`));
  }
}

/** @param {unknown} value */
const json = (value) => new Response(JSON.stringify(value));

/** @param {string} what */
const notFound = (what) => new Response(`not available without the simulator: ${what}`, { status: 404 });

/** Applies a change, which is described in patch.rs. @param {any} old @param {any} change @returns {any} */
function patch(old, change) {
  if (change === null || typeof change !== "object") return change;
  if (Array.isArray(change)) {
    const elements = [...old];
    for (const [index, count, ...added] of change) elements.splice(index, count, ...added);
    return elements;
  }
  if ("=" in change) return change["="];
  const changed = Object.entries(change).map(([key, value]) => [key, patch(old[key], value)]);
  return { ...old, ...Object.fromEntries(changed) };
}

/** Decodes JSON that is compressed with gzip and encoded in Base64. @param {Element | null} element @returns {Promise<any>} */
function decode(element) {
  const text = atob(element?.textContent ?? "");
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
}
