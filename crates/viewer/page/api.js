// @ts-check
// Requests to the server, and the types of its responses and events.

import { showError } from "./dom.js";
import { EmbeddedRun, isExported } from "./embedded.js";

/** The page keeps whole runs of up to this many states, which take about 100 bytes each. */
const MAX_KEPT_STATES = 20_000;

/**
 * @typedef {{ live: boolean, records: boolean, zmq: string | null, server: string, trial: boolean,
 *   strategies: { strategy: string, about: string }[], vehicles: string[], own: string | null, opened: string[] }} PageInfo
 * @typedef {{ path: string, maze: string, width: number | null, height: number | null,
 *   shortest_path: number | null, error: string | null }} MazeEntry
 * @typedef {{ options: string, width: number, height: number, shortest_path: number | null, drawing: string, picture: string }} MazeReading
 * @typedef {{ goal_reached: boolean, ending: string, error: string | null, text: string }} Outcome
 * @typedef {{ mouse: string, own: boolean, kind: "mms" | "client" | null, reason: string, outcome: Outcome | null }} MouseStatus
 * @typedef {{ run: number | null, states: number | null, unsaved_states: number, annotations: number | null, maze: string | null,
 *   mouse_status: MouseStatus | null, pace: number | null, paused: boolean, client: boolean, recordings: number, server: string, opened: string[] }} ServerEvent
 * @typedef {{ id: string, run: number, title: string, maze: string, width: number, height: number, vehicle: string,
 *   start: [number, number], goals: [number, number][], states: number, truth: boolean,
 *   shortest_path: number | null, route: number[], mouse: string | null, race_optimum: number | null, note: string | null }} Source
 * @typedef {{ steps: number, turns: number, time_s: number | null, wall_time_s: number }} RunReport
 * @typedef {{ vehicle: string, known_run_time_s: number | null, fastest_run_lower_bound_s: number | null, fastest_run_proven: boolean }} FastestRun
 * @typedef {{ search_run: RunReport, return_run: RunReport | null, fast_run: RunReport | null, best_run: RunReport | null,
 *   total: RunReport, fast_runs: number, restarts: number, jumps: number }} PhaseReport
 * @typedef {{ mouse: string | null, status: string, run_1: RunReport, run_2: RunReport | null,
 *   score: number | null }} TrialReport
 * @typedef {{ at: number, states: number, annotations: number | null, state: number[], phases: PhaseReport, leg: [number, number],
 *   fastest_run: FastestRun | null, trial: TrialReport | null, sentence: string,
 *   goal_reached: boolean, error: string | null, event: "restart" | "jump" | null, visited_cells: number,
 *   optimistic_distance: number | null, pessimistic_distance: number | null, proven: boolean,
 *   unknown_walls: [number, number][], trail: number[], plan: number[],
 *   mouse: string | null, strategy: string | null, texts: [number, string][], colours: string,
 *   declared_walls: [number, boolean][], missed_walls: number[] }} StateView
 * @typedef {{ states: number, stride: number, optimistic: (number | null)[], pessimistic: (number | null)[] }} BoundsHistory
 * @typedef {"goal" | "return" | "fast_run" | "reset" | "jump" | "wrong_wall" | "solved" | "run_1" | "run_2" | "scored"
 *   | "unscored" | "log"} EventKind
 * @typedef {{ states: number, events: { kind: EventKind, count: number, every: number, states: number[] }[] }} RunEvents
 * @typedef {{ advance: number, glyphs: string[], missing: string, infinity: string,
 *   text: { line: number, full: number, offset: number }, inset: number, colours: Record<string, string>, colour_names: Record<string, string>, light_colours: string,
 *   walls: Record<"known" | "unknown", [number, number, number]>,
 *   trail: { ages: number, min_fade: number, lines: string[], arrows: string[] }, heat: { light: string[], dark: string[] } }} DrawingStyle
 * @typedef {{ moves: string, time_s: number, gate_to_gate_s: number, length_mm: number, cell_count: number, slalom_turns: number,
 *   top_speed_mm_s: number, x_mm: number, y_mm: number, half_cell_mm: number, segments: { turn: string | null,
 *   angle_rad: number, start_s: number, distance_mm: number, x_mm: number, y_mm: number, heading_rad: number,
 *   entry_speed_mm_s: number, duration_s: number, length_mm: number, exit_speed_mm_s: number,
 *   pieces: [duration: number, speed: number, acceleration: number, jerk: number][] }[] }} TimedRun
 * @typedef {{ route: "fastest" | "fewest-cells" | "fewest-turns" | "known-walls" | "driven", timed_run: TimedRun | null,
 *   error: string | null }} RouteRun
 * @typedef {{ name: string, bytes: number, modified: string, being_written: boolean }} RecordingEntry
 * @typedef {{ mouse: string | null, maze: string | null, result: string }} RecordingSummary
 * @typedef {{ steps_to_goal: number | null, repeated_steps: number, steps_until_proven: number | null, path_found: number | null,
 *   shortest_path: number | null, error: string | null, cause: { kind: string, state?: number } | null, steps_until_fastest_run_proven: number | null, vehicle: string, search_time_s: number,
 *   fast_run_time_s: number | null, fast_run_loss_percent: number | null, total_time_s: number | null,
 *   known_run_time_s: number | null, optimal_time_s: number | null }} RunResult
 * @typedef {{ at: number, reached: boolean }} FoundState
 * @typedef {{ lines: [number, string][], first: number, last: number, has_later: boolean }} LogLines
 */

/** An error response, with a message for the user. */
export class ApiError extends Error {
  /** @param {number} status @param {string} text */
  constructor(status, text) {
    super(text || `HTTP status ${status}`);
    /** True if a newer run has replaced the requested run. */
    this.isRunOver = status === 410;
    this.isNotFound = status === 404;
  }
}

/** True if a newer run has replaced the requested run. @param {unknown} error */
export const isRunOver = (error) => error instanceof ApiError && error.isRunOver;

/** Shows an error, unless the next event loads the new run. @param {unknown} error */
export function showUnlessOver(error) {
  if (!isRunOver(error)) showError(error);
  return null;
}

/** The run of an exported page. */
const exported = isExported ? new EmbeddedRun(document) : null;
/** The runs that the page keeps, by the ID of their source. @type {Map<string, { run: number, states: number, vehicle: string, data: EmbeddedRun }>} */
const kept = new Map();
let isConnected = true;

/** Answers requests from the kept runs while the server cannot be reached. @param {boolean} connected */
export const setConnected = (connected) => (isConnected = connected);
/** True if there is no server, or it cannot be reached. */
export const isOffline = () => isExported || !isConnected;
/** True if the page can show a run without the server. @param {Source | null} source */
export const isKept = (source) => source !== null && kept.get(source.id)?.run === source.run;

/** True if the page can show states of a run. @param {Source | null} source */
export const isShowable = (source) => isConnected || isKept(source);

/**
 * Keeps a whole run with the times of a vehicle, so that the page can show it without the server. Returns the number of
 * its states, or null if the server cannot be reached or the run is too long.
 * @param {Source} source @param {number} states @param {string} vehicle @param {AbortSignal} signal
 */
export async function keep(source, states, vehicle, signal) {
  const old = kept.get(source.id);
  if (isKept(source) && old?.states === states && old.vehicle === vehicle) return states;
  if (isOffline() || states > MAX_KEPT_STATES) return null;
  const text = await (await request(sourceUrl(source, "data.html", { vehicle }), { signal })).text();
  const data = new EmbeddedRun(new DOMParser().parseFromString(text, "text/html"));
  kept.set(source.id, { run: source.run, states, vehicle, data });
  return states;
}

/** Returns the run that answers a request instead of the server, if there is one. @param {string} url */
function embeddedRun(url) {
  const [, id, run] = (!isConnected && /^\/api\/sources\/([^/]+)\/.*[?&]run=(\d+)/.exec(url)) || [];
  const found = id === undefined ? undefined : kept.get(id);
  return exported ?? (found?.run === Number(run) ? found?.data : undefined);
}

/** @param {string} url @param {RequestInit} [init] */
async function request(url, init) {
  const response = await (embeddedRun(url)?.respond(url) ?? fetch(url, init));
  if (!response.ok) throw new ApiError(response.status, (await response.text()).trim());
  return response;
}

/** @param {string} url @param {AbortSignal} [signal] @returns {Promise<any>} */
const getJson = async (url, signal) => (await request(url, { signal })).json();

/** @param {string} url @param {object} body */
const post = (url, body) =>
  request(url, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(body),
  });

/** @param {Promise<Response>} response @returns {Promise<string>} */
const recordingId = async (response) => (await (await response).json()).id;

/** @returns {Promise<PageInfo>} */
export const pageInfo = () => getJson("/api/page");
/** @returns {Promise<DrawingStyle>} */
export const drawingStyle = () => getJson("/drawing.json");
/** @returns {Promise<MazeEntry[]>} */
export const mazes = () => getJson("/api/mazes");
/** @param {string} path */
export const thumbnailUrl = (path) => `/api/mazes/picture.svg?path=${encodeURIComponent(path)}`;
/** @param {{ path: string } | { maze: string, drawing: string }} maze a listed maze or a drawing @param {boolean} run true to run the user's own mouse in the maze */
export const loadMaze = (maze, run) => post("/api/maze", { ...maze, run });
/** Returns the mazes that a file of the user can be read as. @param {File} file @returns {Promise<{ maze: string, readings: MazeReading[] }>} */
export const readMaze = async (file) =>
  (await request(`/api/mazes/read?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file })).json();

/** @returns {Promise<RecordingEntry[]>} */
export const recordings = () => getJson("/api/recordings");
/** @param {string} name */
export const openRecording = (name) => recordingId(post("/api/recordings/open", { name }));
/** Returns null if the recording is too large. @param {string} name @returns {Promise<RecordingSummary | null>} */
export const recordingSummary = (name) => getJson(`/api/recordings/summary?name=${encodeURIComponent(name)}`);
/** @param {string} name @param {string} to */
export const renameRecording = (name, to) => post("/api/recordings/rename", { name, to });
/** @param {string} name */
export const deleteRecording = (name) => post("/api/recordings/delete", { name });
/** @param {File} file */
export const uploadRecording = (file) =>
  recordingId(request(`/api/recordings?name=${encodeURIComponent(file.name)}`, { method: "POST", body: file }));
/** @param {string} id */
export const closeRecording = (id) => (kept.delete(id), post("/api/recordings/close", { id }));

/** @param {"run-again" | "stop" | "pause" | "resume" | "step" | "press-reset"} action */
export const act = (action) => post("/api/mouse", { action });
/** @param {string} strategy */
export const runStrategy = (strategy) => post("/api/mouse", { action: "run", strategy });
/** @param {number | null} pace states per second, or null for no limit */
export const setPace = (pace) => post("/api/mouse", { action: "set-pace", pace });

/** @param {string} id @param {AbortSignal} [signal] @returns {Promise<Source>} */
export const source = (id, signal) => getJson(`/api/sources/${id}`, signal);
/**
 * Returns the URL of a resource of a run. Leaves out undefined parameters.
 * @param {Source} source @param {string} resource @param {Record<string, unknown>} [parameters]
 */
export function sourceUrl({ id, run }, resource, parameters = {}) {
  const defined = Object.entries({ run, ...parameters }).filter(([, value]) => value !== undefined);
  return `/api/sources/${id}/${resource}?${new URLSearchParams(defined.map(([name, value]) => [name, `${value}`]))}`;
}
/** @param {Source} source @param {string} resource @param {AbortSignal} [signal] @param {Record<string, unknown>} [parameters] */
const get = (source, resource, signal, parameters) => getJson(sourceUrl(source, resource, parameters), signal);
/** @param {Source} source @param {AbortSignal} signal */
export const drawing = async (source, signal) => (await request(sourceUrl(source, "drawing.svg"), { signal })).text();
/** @param {Source} source @param {number} at the index of the state @param {AbortSignal} signal @param {string} [vehicle] that times the runs @returns {Promise<StateView>} */
export const stateView = (source, at, signal, vehicle) => get(source, "moment", signal, { at, vehicle });
/** @param {Source} source @param {AbortSignal} signal @returns {Promise<BoundsHistory>} */
export const distances = (source, signal) => get(source, "costs", signal);
/** @param {Source} source @param {AbortSignal} signal @returns {Promise<RunEvents>} */
export const runEvents = (source, signal) => get(source, "events", signal);
/** Returns null if the true maze is unknown. @param {Source} source @param {string} vehicle @param {AbortSignal} signal @returns {Promise<RunResult | null>} */
export const result = (source, vehicle, signal) => get(source, "result", signal, { vehicle });
/** @param {Source} source @param {string} vehicle @param {AbortSignal} signal @returns {Promise<RouteRun[]>} */
export const fastRuns = (source, vehicle, signal) => get(source, `fast-runs/${encodeURIComponent(vehicle)}`, signal);
/**
 * Returns the fastest run over the walls that the mouse knows in the state with the index `at` and, if there is one, the
 * latest fast run that it has driven until then.
 * @param {Source} source @param {string} vehicle @param {number} at @param {AbortSignal} signal @returns {Promise<RouteRun[]>}
 */
export const mouseFastRuns = (source, vehicle, at, signal) =>
  get(source, `mouse-fast-runs/${encodeURIComponent(vehicle)}`, signal, { at });
/**
 * Finds the first state after a number of steps since the start or since a leg began, as described for `StateView.leg`.
 * @param {Source} source @param {number} steps @param {number} [leg] @returns {Promise<FoundState>}
 */
export const find = (source, steps, leg) => get(source, "find", undefined, { steps, leg });
/**
 * Returns up to `max` log lines up to the state `at` and up to `max` later lines, but none before the state `from`. Each
 * line is preceded by the index of its state. The response contains all lines from the state `first` to the state `last`.
 * @param {Source} source
 * @param {{ at: number, from: number, max: number, filter: string }} range
 * @param {AbortSignal} signal
 * @returns {Promise<LogLines>}
 */
export const log = (source, range, signal) => get(source, "log", signal, range);
