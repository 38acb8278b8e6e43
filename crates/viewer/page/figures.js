// @ts-check
// The shown moment in figures and in words.

import { counted, grouped, part, set, write } from "./dom.js";
import { HEADINGS } from "./state.js";

/**
 * @typedef {import("./api.js").Moment} Moment
 * @typedef {{ at: number, state: import("./state.js").State, moment: Moment }} Shown
 */

/** @param {HTMLElement} panel @param {import("./api.js").Source | null} source @param {Moment | undefined} moment */
export function showFigures(panel, source, moment) {
  const none = moment ? "no way" : "–";
  /** @param {string} name @param {number | null | undefined} value */
  const figure = (name, value, instead = "–") => write(panel, `.${name} dd`, value == null ? instead : grouped(value));
  figure("steps", moment?.steps);
  figure("turns", moment?.turns);
  figure("visited", moment?.visited);
  figure("open-cost", moment?.open, none);
  figure("closed-cost", moment?.closed, none);
  figure("shortest", source?.shortest_path, source?.truth ? "no way" : "–");
  write(panel, ".solved", moment?.solved ? "solved" : "not solved");
  set(panel, "data-solved", moment?.solved ?? false);
}

/** Tells those who hear the page. @param {HTMLElement} panel @param {Shown | null} shown */
export function tell(panel, shown) {
  const words = [part(panel, ".place").textContent];
  if (shown) {
    const { state, moment } = shown;
    words.push(`mouse at (${state.x}, ${state.y}) heading ${HEADINGS[state.heading]}`);
    words.push(`${counted(moment.visited, "cell")} visited`, moment.solved ? "solved" : "not solved");
  }
  write(panel, ".words", words.join(", "));
}
