// @ts-check
// The data of an exported page, which contains the server's responses for one recording and therefore needs no server.

/** The number of states in a block. */
const BLOCK_STATES = 256;
/** The maximum number of decoded blocks in memory. */
const MAX_BLOCKS = 4;

/** True if this page is exported. */
export const isExported = document.documentElement.classList.contains("exported");

const blocks = document.querySelectorAll("[data-embedded=states]");
/** The views in recently used blocks, by the number of the block. @type {Map<number, Promise<any[]>>} */
const recent = new Map();
/** The responses by path. @type {Promise<Record<string, string>> | undefined} */
let responses;
/** The lines of the log, each with the index of its state. @type {Promise<[number, string][]> | undefined} */
let log;

/** Returns the response to a request. @param {string} url @returns {Promise<Response>} */
export async function respond(url) {
  const { pathname, searchParams } = new URL(url, "http://localhost");
  const resource = pathname.split("/").at(-1);
  if (resource === "moment") return json(await stateView(Number(searchParams.get("at"))));
  if (resource === "log") return json(await logLines(searchParams));
  responses ??= decode(document.querySelector("[data-embedded=responses]"));
  const response = (await responses)[decodeURIComponent(pathname)];
  if (response !== undefined) return new Response(response);
  console.error(`The exported page does not contain ${url}.`);
  return new Response(`not available on an exported page: ${pathname}`, { status: 404 });
}

/** @param {unknown} value */
const json = (value) => new Response(JSON.stringify(value));

/** @param {number} index */
async function stateView(index) {
  const number = Math.floor(index / BLOCK_STATES);
  const views = recent.get(number) ?? decodeBlock(number);
  // The most recently used block is the last one.
  recent.delete(number);
  recent.set(number, views);
  if (recent.size > MAX_BLOCKS) recent.delete([...recent.keys()][0]);
  return (await views)[index % BLOCK_STATES];
}

/** @param {number} number @returns {Promise<any[]>} */
async function decodeBlock(number) {
  /** @type {any[]} */
  const changes = await decode(blocks[number]);
  /** @type {any} */
  let view = null;
  return changes.map((change) => (view = patch(view, change)));
}

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

/** Selects log lines as the server does. @param {URLSearchParams} query @returns {Promise<import("./api.js").LogLines>} */
async function logLines(query) {
  const [at, from, max] = ["at", "from", "max"].map((name) => Number(query.get(name)));
  const filter = (query.get("filter") ?? "").toLowerCase();
  log ??= decode(document.querySelector("[data-embedded=log]"));
  const lines = (await log).filter(([state, text]) => state >= from && text.toLowerCase().includes(filter));
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

/** Decodes JSON that is compressed with gzip and encoded in Base64. @param {Element | null} element @returns {Promise<any>} */
function decode(element) {
  const text = atob(element?.textContent ?? "");
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
}
