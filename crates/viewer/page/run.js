// @ts-check
// The form that runs a bundled strategy. The server runs the strategy as an ordinary client.

import * as api from "./api.js";
import { clearError, confirmReset, query, setAttributes, setText, showError } from "./dom.js";

export class RunForm {
  #form;
  #run;
  #stop;
  #shown = "";
  /** @type {api.RunnerStatus | null} */
  #status = null;

  /** @param {HTMLElement} panel @param {api.PageInfo["strategies"]} strategies @param {() => number} liveStates */
  constructor(panel, strategies, liveStates) {
    const form = query(panel, "form.run", HTMLFormElement);
    const strategy = query(form, "[name=strategy]", HTMLSelectElement);
    const pace = query(form, "[name=pace]", HTMLSelectElement);
    this.#form = form;
    this.#run = query(form, "[name=run]", HTMLButtonElement);
    this.#stop = query(form, "[name=stop]", HTMLButtonElement);
    strategy.replaceChildren(...strategies.map(({ name }) => new Option(name)));
    strategy.onchange = () => setText(form, ".about", strategies[strategy.selectedIndex]?.about ?? "");
    strategy.dispatchEvent(new Event("change"));
    form.onsubmit = async (event) => {
      event.preventDefault();
      clearError();
      // The states of a bundled strategy are deleted without confirmation, since another run reproduces them.
      const states = this.#status ? 0 : liveStates();
      if (states > 0 && !(await confirmReset("Run", strategy.value, states))) return;
      api.startMouse(strategy.value, Number(pace.value)).catch(showError);
    };
    this.#stop.onclick = () => api.stopMouse().catch(showError);
    form.hidden = false;
  }

  /** @param {api.RunnerStatus | null} status */
  show(status) {
    const shown = JSON.stringify(status);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#status = status;
    const running = status?.running ?? false;
    const [pressed, next] = running ? [this.#run, this.#stop] : [this.#stop, this.#run];
    next.disabled = false;
    if (document.activeElement === pressed) next.focus(); // a disabled button loses the focus
    pressed.disabled = true;
    setAttributes(this.#form, { "data-running": running });
    const result = status?.says || (running ? "searching" : "ended");
    setText(this.#form, ".result", status ? `${status.strategy}: ${result}` : "");
  }
}
