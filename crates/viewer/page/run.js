// @ts-check
// The controls of the mouse: the user's own mouse, which the simulator has started, or a bundled strategy.

import * as api from "./api.js";
import { buttonOf, clearError, confirmAction, query, setAttributes, setText, showError } from "./dom.js";

/** The strategy that is selected at first. It proves the shortest path, and then drives it. */
const FIRST_STRATEGY = "shortest-path-search";

export class RunForm {
  #form;
  #own;
  #isTrial;
  /** The number of states that a reset deletes. */
  #unsavedStates = 0;
  #buttons;
  #strategy;
  #shown = "";
  /** The last event. @type {Pick<api.ServerEvent, "mouse_status" | "paused" | "client">} */
  #event = { mouse_status: null, paused: false, client: false };

  /** @param {HTMLElement} panel @param {api.PageInfo} info */
  constructor(panel, { strategies, own, trial }) {
    const form = query(panel, "form.run", HTMLFormElement);
    this.#form = form;
    this.#own = own;
    this.#isTrial = trial;
    /** @param {string} name @param {() => Promise<unknown>} act */
    const button = (name, act) =>
      buttonOf(form, name, () => {
        clearError();
        act().catch(showError);
      });
    this.#buttons = {
      again: button("again", () => this.#runAgain()),
      stop: button("stop", () => api.act("stop")),
      pause: button("pause", () => api.act(this.#event.paused ? "resume" : "pause")),
      step: button("step", () => api.act("step")),
      reset: button("reset", () => api.act("press-reset")),
      run: buttonOf(form, "run", null),
    };
    this.#buttons.again.hidden = !own;
    this.#buttons.run.classList.toggle("primary", !own);
    panel.classList.toggle("own-mouse", own !== null);
    this.#strategy = query(form, "[name=strategy]", HTMLSelectElement);
    this.#strategy.replaceChildren(...strategies.map(({ strategy: name }) => new Option(name, name, false, name === FIRST_STRATEGY)));
    this.#strategy.onchange = () => setText(form, ".about", strategies[this.#strategy.selectedIndex]?.about ?? "");
    this.#strategy.dispatchEvent(new Event("change"));
    form.onsubmit = (event) => {
      event.preventDefault();
      void this.#runBundled();
    };
    query(form, ".bundled").hidden = trial;
    form.hidden = false;
  }

  async #runAgain() {
    const warning = "Another client is searching the maze. It will lose its states.";
    const isSearching = this.#event.client && !(this.#isRunning && this.#event.mouse_status?.own);
    const states = isSearching ? this.#unsavedStates : 0;
    if (states > 0 && !(await confirmAction("Run", this.#own ?? "", states, { warning }))) return;
    await api.act("run-again");
  }

  async #runBundled() {
    clearError();
    const strategy = this.#strategy.value;
    // The states of a bundled strategy are deleted without confirmation, since another run reproduces them.
    const states = this.#event.mouse_status && !this.#event.mouse_status.own ? 0 : this.#unsavedStates;
    if (states > 0 && !(await confirmAction("Run", strategy, states))) return;
    api.runStrategy(strategy).catch(showError);
  }

  /**
   * Asks whether to load a maze if that deletes states or stops the mouse.
   * @param {string} maze
   * @returns {Promise<"" | "confirm" | "run">} "run" to run the user's own mouse there
   */
  async confirmMaze(maze) {
    const states = this.#unsavedStates;
    const running = this.#isRunning ? this.#event.mouse_status?.mouse : undefined;
    if (states === 0 && !running) return "confirm";
    const warning = running ? `${running} is running. It will be stopped, because its map belongs to the old maze.` : "";
    return confirmAction("Load", maze, states, { warning, mouse: this.#own ?? undefined });
  }

  get #isRunning() {
    return this.#event.mouse_status !== null && this.#event.mouse_status.outcome === null;
  }

  /** @param {api.ServerEvent} event */
  show({ mouse_status: mouse, paused, client, unsaved_states: unsaved }) {
    this.#unsavedStates = unsaved;
    const shown = JSON.stringify([mouse, paused, client]);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#event = { mouse_status: mouse, paused, client };
    const form = this.#form;
    const running = this.#isRunning;
    const { again, stop, pause, step, reset, run } = this.#buttons;
    const pressed = document.activeElement;
    for (const button of [stop, pause, step]) button.disabled = !running;
    reset.hidden = mouse?.kind !== "mms";
    reset.disabled = !running;
    run.disabled = this.#strategy.disabled = running || client;
    // A disabled button loses the focus.
    if (pressed === run && run.disabled) stop.focus();
    if (pressed instanceof HTMLButtonElement && pressed.disabled && form.contains(pressed)) (this.#own ? again : run).focus();
    setText(form, "[name=pause]", paused && running ? "Resume" : "Pause");
    setText(form, "[name=again]", mouse?.own ? "Run again" : `Run ${this.#own}`);
    const phase = !mouse ? "" : !running ? "ended" : paused ? "paused" : "running";
    setText(form, ".name", mouse?.mouse ?? this.#own ?? "Mouse");
    setText(form, ".phase", phase);
    setText(form, ".result", mouse?.outcome?.text ?? "");
    setText(form, ".reason", mouse?.reason ?? "");
    const blocked = client && !running ? "Another client is searching the maze. A strategy can run after the client has disconnected." : "";
    setText(form, ".blocked", blocked);
    query(form, ".bundled").hidden = this.#isTrial || (running && (mouse?.own ?? false));
    setAttributes(form, { "data-running": running, "data-ending": mouse?.outcome?.ending ?? "" });
  }
}
