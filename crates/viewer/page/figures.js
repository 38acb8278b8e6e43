// @ts-check
// Shows the figures of a state, and announces the state to screen readers.

import { formatNumber, pluralize, query, setAttributes, setText } from "./dom.js";
import { HEADINGS } from "./state.js";

/**
 * @typedef {import("./api.js").StateView} StateView
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
  show("optimistic", view?.open, none);
  show("pessimistic", view?.closed, none);
  show("actual", source?.shortest_path, source?.truth ? "no path" : "–");
  setText(panel, ".proven", view?.solved ? "proven" : "not proven");
  setAttributes(panel, { "data-proven": view?.solved ?? false });
}

/** @param {HTMLElement} panel @param {Shown | null} shown */
export function announce(panel, shown) {
  const parts = [query(panel, ".position").textContent];
  if (shown) {
    const { state, view } = shown;
    parts.push(`mouse at (${state.x}, ${state.y}) heading ${HEADINGS[state.heading]}`);
    parts.push(`${pluralize(view.visited, "cell")} visited`, `shortest path ${view.solved ? "" : "not "}proven`);
  }
  setText(panel, ".announcement", parts.join(", "));
}
