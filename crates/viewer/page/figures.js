// @ts-check
// Shows the figures of a state, and announces the state to screen readers.

import { formatNumber, formatTime, pluralize, query, setAttributes, setText } from "./dom.js";
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
  /** @param {string} name @param {number | null | undefined} value */
  const show = (name, value, placeholder = "–") =>
    setText(panel, `.${name} dd`, value == null ? placeholder : formatNumber(value));
  show("steps", view?.steps);
  show("turns", view?.turns);
  show("visited", view?.visited);
  setText(panel, ".time dd", view ? formatTime(view.phases.total.ms) : "–");
  showPhases(panel, view?.phases);
  setText(panel, ".happened", view ? describeEvents(view) : "");
  setAttributes(panel, { "data-event": view?.event ?? "" });
  show("optimistic", view?.open, none);
  show("pessimistic", view?.closed, none);
  show("actual", source?.shortest_path, source?.truth ? "no path" : "–");
  setText(panel, ".proven", view?.solved ? "proven" : "not proven");
  setAttributes(panel, { "data-proven": view?.solved ?? false });
}

/** @param {HTMLElement} panel @param {PhaseReport | undefined} phases */
function showPhases(panel, phases) {
  /** @param {string} name @param {RunReport | null | undefined} run */
  const show = (name, run) => {
    const values = run ? [formatNumber(run.steps), formatNumber(run.turns), formatTime(run.ms)] : ["–", "–", "–"];
    values.forEach((value, i) => setText(panel, `.phases .${name} td:nth-of-type(${i + 1})`, value));
  };
  const isSeveral = (phases?.fast_runs ?? 0) > 1;
  show("search-run", phases?.search_run);
  show("return-run", phases?.return_run);
  show("fast-run", phases?.fast_run);
  show("best-run", phases?.best_run);
  setText(panel, ".phases .fast-run th", isSeveral ? `Fast run ${formatNumber(phases?.fast_runs ?? 0)}` : "Fast run");
  query(panel, ".phases .best-run").hidden = !isSeveral;
}

/** Describes the walls of a visited cell that the mouse does not know. @param {number} cell @param {StateView | undefined} view */
export function describeUnknownWalls(cell, view) {
  const [, sides] = view?.unknown_walls.find(([other]) => other === cell) ?? [];
  if (!sides) return "";
  const names = HEADINGS.filter((_, heading) => sides & (1 << heading));
  return ` · unknown ${names.length === 1 ? "wall" : "walls"}: ${names.join(", ")}`;
}

/** Describes how often the mouse was put back or jumped, and whether it was in this state. @param {StateView} view */
function describeEvents({ event, phases: { put_backs, jumps } }) {
  /** @param {number} count */
  const times = (count) => (count === 1 ? "once" : `${formatNumber(count)} times`);
  const parts = [];
  if (event === "put-back") parts.push("in this state");
  if (put_backs > 1 || (put_backs && !parts.length)) parts.push(times(put_backs));
  const texts = parts.length ? [`Put back to the start ${parts.join(", ")}`] : [];
  if (event === "jump") texts.push("Jumped to this cell");
  else if (jumps) texts.push(`Jumped to another cell ${times(jumps)}`);
  return texts.join(". ");
}

/** @param {HTMLElement} panel @param {Shown | null} shown */
export function announce(panel, shown) {
  const parts = [query(panel, ".position").textContent];
  if (shown) {
    const { state, view } = shown;
    parts.push(`mouse at (${state.x}, ${state.y}) heading ${HEADINGS[state.heading]}`);
    if (view.event) parts.push(view.event === "jump" ? "jumped to this cell" : "put back to the start");
    parts.push(`${pluralize(view.visited, "cell")} visited`, `shortest path ${view.solved ? "" : "not "}proven`);
  }
  setText(panel, ".announcement", parts.join(", "));
}
