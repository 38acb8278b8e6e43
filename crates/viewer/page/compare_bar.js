// @ts-check
// The bar above several panels, which links them: when the user or playback moves one panel to another state, the other
// panels move to the state that corresponds to it.

import * as api from "./api.js";
import { oneAtATime, query, recall, remember, setText, sleep } from "./dom.js";

/** @typedef {import("./panel.js").Panel} Panel */

/** What the panels have in common if they are linked, and what happens if a run is too short. */
const KINDS = {
  off: ["Each panel moves on its own.", ""],
  state: ["All panels show the same state number.", "A shorter run stays at its last state."],
  step: ["All panels show the same number of steps since the start.", "A shorter run stays at its last state."],
  phase: [
    "All panels show the same run (search, return or fast run) and the same steps since it began.",
    "A panel in which this run is shorter or missing stays at the end of this run or of the run before it.",
  ],
};
/** Milliseconds between two moves of the other panels while the moved panel follows a running search. */
const FOLLOW_PAUSE = 100;

/** @typedef {keyof typeof KINDS} LinkKind */

export class CompareBar {
  #element = query(document, "#compare");
  #panels;
  /** The panel that was moved last. @type {Panel | null} */
  #leader = null;
  /** The state that the leader showed before it was moved. @type {import("./figures.js").Shown | null} */
  #before = null;
  /** How the panels are linked. @type {LinkKind} */
  kind = "state";
  /** The last search for each panel. @type {WeakMap<Panel, { key: string, source: api.Source, states: number, found: Promise<api.FoundState> }>} */
  #searches = new WeakMap();

  /** @param {Map<string, Panel>} panels the open panels by ID */
  constructor(panels) {
    this.#panels = panels;
    for (const button of this.#buttons) {
      const kind = /** @type {LinkKind} */ (button.value);
      button.title = KINDS[kind].join(" ").trim();
      button.onclick = () => this.#link(kind);
    }
    const stored = recall("link");
    this.setKind(isLinkKind(stored) ? stored : "state");
  }

  get #buttons() {
    return [...this.#element.querySelectorAll("button")].filter(({ name }) => name === "link");
  }

  /** @param {LinkKind} kind */
  setKind(kind) {
    this.kind = kind;
    remember("link", kind);
    for (const button of this.#buttons) button.ariaPressed = `${button.value === kind}`;
    setText(this.#element, ".about", KINDS[kind][0]);
  }

  /** Moves the other panels to the states that correspond to the active panel. @param {LinkKind} kind */
  #link(kind) {
    this.setKind(kind);
    this.#leader = [...this.#panels.values()].find(({ element }) => element.classList.contains("active")) ?? null;
    this.#before = null;
    void this.sync();
  }

  /** Adds a panel. No panel moves until the user moves one. @param {Panel} panel */
  add(panel) {
    this.#leader = null;
    panel.timeline.onMove = () => {
      this.#leader = panel;
      this.#before = panel.shown;
    };
    this.#element.hidden = this.#panels.size < 2;
  }

  /** @param {Panel} panel */
  remove(panel) {
    panel.timeline.onMove = () => {};
    if (this.#leader === panel) this.#leader = null;
    this.#element.hidden = this.#panels.size < 2;
  }

  /** Moves the other panels if the moved panel shows another state or a run has grown. */
  sync = oneAtATime(async () => {
    const [leader, kind] = [this.#leader, this.kind];
    if (!leader?.shown || kind === "off") return;
    const { shown, timeline } = leader;
    // The leader has not shown its new state yet.
    if (shown === this.#before && shown.index !== timeline.target) return;
    const others = [...this.#panels.values()].filter((panel) => panel !== leader);
    await Promise.all(others.map((panel) => this.#move(panel, shown, kind)));
    if (timeline.following) await sleep(FOLLOW_PAUSE);
  });

  /** @param {Panel} panel @param {import("./figures.js").Shown} shown @param {Exclude<LinkKind, "off">} kind */
  async #move(panel, shown, kind) {
    const { source, timeline } = panel;
    if (!source || timeline.states === 0) return;
    let index = shown.index;
    if (kind !== "state") {
      if (api.isOffline()) return; // only the server can find the state
      const found = await this.#find(panel, source, shown, kind).catch(api.showUnlessOver);
      if (!found || panel.source !== source) return;
      index = found.at;
    }
    // The user may have moved this panel, or changed the link, in the meantime.
    if (panel === this.#leader || kind !== this.kind) return;
    const isThere = timeline.target === Math.min(index, timeline.states - 1);
    if (!isThere || timeline.following || timeline.playing) timeline.moveLinked(index);
  }

  /**
   * Finds the state of a panel that corresponds to the shown state of another panel.
   * @param {Panel} panel @param {api.Source} source @param {import("./figures.js").Shown} shown @param {"step" | "phase"} kind
   */
  async #find(panel, source, { view }, kind) {
    const { states } = panel.timeline;
    const [leg, steps] = kind === "phase" ? view.leg : [undefined, view.phases.total.steps];
    const key = `${leg} ${steps}`;
    const last = this.#searches.get(panel);
    if (last?.key === key && last.source === source) {
      const found = await last.found.catch(() => null);
      // A state that has been found stays the same while the run grows.
      if (found?.reached || (found && last.states === states)) return found;
    }
    const found = api.find(source, steps, leg);
    this.#searches.set(panel, { key, source, states, found });
    return found;
  }
}

/** @param {unknown} kind @returns {kind is LinkKind} */
export const isLinkKind = (kind) => typeof kind === "string" && Object.hasOwn(KINDS, kind);
