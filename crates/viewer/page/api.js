// @ts-check
// What the server answers, and how it is asked.

/**
 * @typedef {{ live: boolean, records: boolean, version: string, zmq: string, server: string,
 *   strategies: { name: string, about: string }[], opened: { id: string, title: string }[] }} PageFacts
 * @typedef {{ path: string, name: string, width: number | null, height: number | null,
 *   shortest_path: number | null, error: string | null }} MazeEntry
 * @typedef {{ strategy: string, running: boolean, says: string }} MouseRun
 * @typedef {{ run: number | null, states: number | null, maze: string | null,
 *   mouse: MouseRun | null, recordings: number, server: string, opened: string[] }} ServerEvent
 * @typedef {{ id: string, run: number, title: string, width: number, height: number,
 *   start: [number, number], goals: [number, number][], states: number, truth: boolean,
 *   shortest_path: number | null, note: string | null }} Source
 * @typedef {{ at: number, states: number, state: number[], steps: number, turns: number, visited: number, open: number | null,
 *   closed: number | null, solved: boolean, trail: number[] }} Moment
 * @typedef {{ states: number, stride: number, open: (number | null)[], closed: (number | null)[] }} Costs
 * @typedef {{ advance: number, digits: string[], heat: { light: string[], dark: string[] } }} Drawing
 * @typedef {{ name: string, bytes: number, modified: string }} RecordingEntry
 */

/** The server said no, in a sentence that can be shown. */
export class Refused extends Error {
  /** @param {number} status @param {string} text */
  constructor(status, text) {
    super(text || `the server answered ${status}`);
    /** Whether the run that was asked about is over. */
    this.over = status === 410;
    /** Whether there is no such thing, or no more. */
    this.gone = status === 404;
  }
}

/** @param {string} address @param {RequestInit} [init] */
async function ask(address, init) {
  const answer = await fetch(address, init);
  if (!answer.ok) throw new Refused(answer.status, (await answer.text()).trim());
  return answer;
}

/** @param {string} address @param {AbortSignal} [signal] @returns {Promise<any>} */
const json = async (address, signal) => (await ask(address, { signal })).json();

/** @param {string} address @param {object} body */
const post = (address, body) =>
  ask(address, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
  });

/** @param {Promise<Response>} opening @returns {Promise<string>} the id of the opened recording */
const opened = async (opening) => (await (await opening).json()).id;

/** @returns {Promise<PageFacts>} */
export const pageFacts = () => json("/api/page");
/** @returns {Promise<Drawing>} */
export const drawingFacts = () => json("/drawing.json");
/** @returns {Promise<MazeEntry[]>} */
export const mazes = () => json("/api/mazes");
/** @param {string} path */
export const mazePicture = (path) => `/api/mazes/picture.svg?path=${encodeURIComponent(path)}`;
/** @param {string} path */
export const serveMaze = (path) => post("/api/maze", { path });

/** @returns {Promise<RecordingEntry[]>} */
export const recordings = () => json("/api/recordings");
/** @param {string} name */
export const openRecording = (name) => opened(post("/api/recordings/open", { name }));
/** @param {File} file */
export const loadRecording = (file) =>
  opened(ask(`/api/recordings?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file }));
/** @param {string} id */
export const closeRecording = (id) => post("/api/recordings/close", { id });

/** @param {string} strategy @param {number} pace_ms */
export const runMouse = (strategy, pace_ms) => post("/api/mouse/run", { strategy, pace_ms });
export const stopMouse = () => post("/api/mouse/stop", {});

/** @param {string} id @param {AbortSignal} signal @returns {Promise<Source>} */
export const source = (id, signal) => json(`/api/sources/${id}`, signal);
/** @param {Source} source @param {string} what @param {string} [query] */
export const sourceAddress = ({ id, run }, what, query = "") => `/api/sources/${id}/${what}?run=${run}${query}`;
/** @param {Source} source @param {AbortSignal} signal */
export const drawing = async (source, signal) => (await ask(sourceAddress(source, "drawing.svg"), { signal })).text();
/** @param {Source} source @param {number} at @param {AbortSignal} signal @returns {Promise<Moment>} */
export const moment = (source, at, signal) => json(sourceAddress(source, "moment", `&at=${at}`), signal);
/** @param {Source} source @param {AbortSignal} signal @returns {Promise<Costs>} */
export const costs = (source, signal) => json(sourceAddress(source, "costs"), signal);
