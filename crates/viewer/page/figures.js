// @ts-check
// Shows the figures of a state, and announces the state to screen readers.

import { formatCount, formatNumber, formatTime, pluralize, query, setAttributes, setText } from "./dom.js";
import { HEADINGS } from "./state.js";

/**
 * @typedef {import("./api.js").StateView} StateView
 * @typedef {import("./api.js").PhaseReport} PhaseReport
 * @typedef {import("./api.js").RunReport} RunReport
 * @typedef {{ index: number, state: import("./state.js").State, view: StateView }} Shown
 */

/** @param {HTMLElement} panel @param {import("./api.js").Source | null} source @param {StateView | undefined} view */
export function showFigures(panel, source, view) {
  const none = view ? "no path" : "–";
  const isTrial = source?.mouse != null || view?.trial != null;
  /** @param {string} name @param {number | null | undefined} value */
  const show = (name, value, placeholder = "–") =>
    setText(panel, `.${name} dd`, value == null ? placeholder : formatCount(value));
  const trialSteps = view?.trial && view.trial.run_1.steps + (view.trial.run_2?.steps ?? 0);
  const trialTurns = view?.trial && view.trial.run_1.turns + (view.trial.run_2?.turns ?? 0);
  show("steps", trialSteps ?? view?.phases.total.steps);
  show("turns", trialTurns ?? view?.phases.total.turns);
  show("visited", view?.visited_cells);
  showTime(query(panel, ".time dd"), view?.phases.total);
  query(panel, ".time").hidden = isTrial;
  if (isTrial) showTrial(panel, view?.trial, source?.mouse);
  else showPhases(panel, view?.phases);
  query(panel, ".phases").classList.toggle("untimed", isTrial);
  for (const part of [".trial", ".trial-runs"]) query(panel, part).hidden = !isTrial;
  query(panel, ".runs").hidden = isTrial;
  const isSeveral = (view?.phases.fast_runs ?? 0) > 1;
  setAttributes(query(panel, ".phases"), { "data-rows": isTrial ? 2 : isSeveral ? 4 : 3 });
  setText(panel, ".path-name", isTrial ? "Fastest race" : "Shortest path").title = isTrial ? "Time steps from the start to the goal" : "Steps from the start to the goal";
  setText(panel, ".actual dt", isTrial ? "optimum" : "actual");
  setText(panel, ".happened", view && !view.trial ? describeEvents(view) : "");
  show("optimistic", view?.optimistic_distance, none);
  show("pessimistic", view?.pessimistic_distance, none);
  show("actual", isTrial ? source?.race_optimum : source?.shortest_path, source?.truth ? "no path" : "–");
  setText(panel, ".proven", proof(view));
  setText(panel, ".sentence", view?.sentence ?? "");
  showFastestRun(panel, view?.fastest_run);
  query(panel, ".fastest-run").hidden = isTrial;
  setAttributes(panel, { "data-event": view?.event ?? "", "data-proven": view?.proven ?? false });
}

/** Describes what the known walls prove. @param {StateView | undefined} view */
function proof(view) {
  if (view && view.optimistic_distance == null) return "goal unreachable";
  return view?.proven ? "proven" : "not proven";
}

/** Shows the time of the mouse, and that of the computer as a tooltip. @param {HTMLElement} element @param {RunReport | null | undefined} run */
function showTime(element, run) {
  element.textContent = run?.time_s == null ? "–" : formatTime(run.time_s);
  element.title = run ? `This computer took ${formatTime(run.wall_time_s)}` : "";
}

/** Shows a row of the table of phases. @param {HTMLElement} panel @param {string} name @param {RunReport | null | undefined} run */
function showRun(panel, name, run) {
  const row = query(panel, `.phases .${name.replace("_", "-")}`);
  const values = run ? [formatCount(run.steps), formatCount(run.turns)] : ["–", "–"];
  values.forEach((value, i) => setText(row, `td:nth-of-type(${i + 1})`, value));
  showTime(query(row, "td:nth-of-type(3)"), run);
}

/** Shows what is known about the fastest run. @param {HTMLElement} panel @param {import("./api.js").FastestRun | null | undefined} run */
function showFastestRun(panel, run) {
  const time = run?.known_run_time_s == null ? "none known" : formatTime(run.known_run_time_s);
  setText(panel, ".fastest-run .known", run ? time : "–");
  setText(panel, ".fastest-run .run-proven", run?.fastest_run_proven ? "proven" : "not proven");
  setText(panel, ".phases .vehicle", run ? `Times of ${run.vehicle}` : "");
  const bound = run?.fastest_run_lower_bound_s;
  query(panel, ".fastest-run").title = bound == null ? "" : `No run of ${run?.vehicle} is faster than ${formatTime(bound)}`;
  setAttributes(query(panel, ".fastest-run"), { "data-proven": run?.fastest_run_proven ?? false });
}

/**
 * @param {HTMLElement} panel @param {import("./api.js").TrialReport | null | undefined} trial
 * @param {string | null | undefined} robot
 */
function showTrial(panel, trial, robot) {
  setText(panel, ".trial .status", trial?.status.replaceAll("_", " ") ?? "");
  setText(panel, ".robot dd", trial?.mouse ?? robot ?? "–");
  setText(panel, ".score dd", trial?.score?.toFixed(3) ?? "–");
  for (const run of /** @type {const} */ (["run_1", "run_2"])) showRun(panel, run, trial?.[run]);
}

/** @param {HTMLElement} panel @param {PhaseReport | undefined} phases */
function showPhases(panel, phases) {
  const isSeveral = (phases?.fast_runs ?? 0) > 1;
  for (const run of /** @type {const} */ (["search_run", "return_run", "fast_run", "best_run"])) showRun(panel, run, phases?.[run]);
  setText(panel, ".phases .fast-run th", isSeveral ? `Fast run ${formatNumber(phases?.fast_runs ?? 0)}` : "Fast run");
  query(panel, ".phases .best-run").hidden = !isSeveral;
}

/**
 * Shows what the mouse has achieved until the last state, and offers the state that shows why it failed.
 * @param {HTMLElement} panel @param {import("./api.js").RunResult} result @param {StateView} view @param {(index: number) => void} seek
 */
export function showResult(panel, result, { at, optimistic_distance: possible, fastest_run: bounds }, seek) {
  const { steps_to_goal: goal, repeated_steps: repeated, steps_until_proven: proven, path_found: found, shortest_path: optimum } = result;
  const { error, cause } = result;
  const lines = [goal === null ? `Goal not found${error ? `: ${error}` : ""}` : `Goal found after ${pluralize(goal, "step")}`];
  if (repeated > 0) lines.push(`${pluralize(repeated, "step")} of the search through known cells`);
  if (proven !== null) lines.push(`Shortest path proven after ${pluralize(proven, "step")}`);
  else if (possible !== null) lines.push(`Shortest path not proven: unknown walls leave room for a path of ${pluralize(possible, "step")}`);
  const { steps_until_fastest_run_proven: runProven, vehicle, fast_run_time_s: time, fast_run_loss_percent: loss, total_time_s: total } = result;
  const bound = bounds?.fastest_run_lower_bound_s;
  if (runProven !== null) lines.push(`Fastest run of ${vehicle} proven after ${pluralize(runProven, "step")}`);
  else if (bound != null) lines.push(`Fastest run of ${vehicle} not proven: unknown walls leave room for a run of ${formatTime(bound)}`);
  if (found !== null && optimum) {
    const excess = (100 * (found - optimum)) / optimum;
    lines.push(`Path found: ${pluralize(found, "step")}, ${excess > 0 ? `${excess.toFixed(1)} % above the optimum of ${optimum}` : "the optimum"}`);
  }
  if (time !== null && total !== null) {
    const excess = loss ? `${loss.toFixed(1)} % above the optimum of ${formatTime(result.optimal_time_s ?? 0)}` : "the optimum";
    lines.push(`Fast run: ${formatTime(time)}, ${excess}; ${formatTime(total)} with the search and the return`);
  }
  const items = lines.map((textContent) => Object.assign(document.createElement("li"), { textContent }));
  const state = cause?.state;
  if (state !== undefined && state !== at) {
    const button = Object.assign(document.createElement("button"), { name: "show-cause", textContent: "Show this state" });
    button.onclick = () => seek(state);
    items[0].append(" ", button);
  }
  query(panel, ".outcome ul").replaceChildren(...items);
}

/** Describes how often the mouse was put back or jumped, and whether it was in this state. @param {StateView} view */
function describeEvents({ event, goal_reached, error, phases: { restarts, jumps } }) {
  /** @param {number} count */
  const times = (count) => (count === 1 ? "once" : `${formatNumber(count)} times`);
  const texts = [];
  if (event === "restart") texts.push(`Put back at the start in this state${restarts > 1 ? ` (${times(restarts)} so far)` : ""}`);
  else if (restarts) texts.push(`Put back at the start ${times(restarts)}`);
  if (event === "jump") texts.push("Jumped to this cell");
  else if (jumps) texts.push(`Jumped to another cell ${times(jumps)}`);
  if (error) texts.push(`Goal ${goal_reached ? "reached" : "not reached"}: ${error}`);
  return texts.join(". ");
}

/** @param {HTMLElement} panel @param {Shown | null} shown @param {string[]} events what happened in this state */
export function announce(panel, shown, events) {
  const parts = [query(panel, ".position").textContent];
  if (shown) {
    const { state, view } = shown;
    parts.push(`mouse at (${state.x}, ${state.y}) heading ${HEADINGS[state.heading]}`);
    if (view.trial) parts.push(`${view.trial.status.replaceAll("_", " ")}${view.trial.score === null ? "" : `, score ${view.trial.score.toFixed(3)}`}`);
    if (view.event) parts.push(view.event === "jump" ? "jumped to this cell" : "put back at the start");
    parts.push(...events, `${pluralize(view.visited_cells, "cell")} visited`, `${view.trial ? "fastest race" : "shortest path"} ${proof(view)}`);
  }
  setText(panel, ".announcement", parts.join(", "));
}
