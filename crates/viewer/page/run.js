// @ts-check
// Runs a bundled mouse, which comes through the same door as any client.

import * as api from "./api.js";
import { clearProblem, confirmed, part, report, set, write } from "./dom.js";

export class RunForm {
  #form;
  #run;
  #stop;
  #shown = "";
  /** @type {api.MouseRun | null} */
  #mouse = null;

  /** @param {HTMLElement} panel @param {api.PageFacts["strategies"]} strategies @param {() => number} states */
  constructor(panel, strategies, states) {
    const form = part(panel, "form.run", HTMLFormElement);
    const strategy = part(form, "[name=strategy]", HTMLSelectElement);
    const pace = part(form, "[name=pace]", HTMLSelectElement);
    this.#form = form;
    this.#run = part(form, "[name=run]", HTMLButtonElement);
    this.#stop = part(form, "[name=stop]", HTMLButtonElement);
    strategy.replaceChildren(...strategies.map(({ name }) => new Option(name)));
    strategy.onchange = () => write(form, ".about", strategies[strategy.selectedIndex]?.about ?? "");
    strategy.dispatchEvent(new Event("change"));
    form.onsubmit = async (event) => {
      event.preventDefault();
      clearProblem();
      // What a bundled mouse has found, it finds again.
      const lost = this.#mouse ? 0 : states();
      if (lost > 0 && !(await confirmed("Run", strategy.value, lost))) return;
      api.runMouse(strategy.value, Number(pace.value)).catch(report);
    };
    this.#stop.onclick = () => api.stopMouse().catch(report);
    form.hidden = false;
  }

  /** @param {api.MouseRun | null} mouse */
  show(mouse) {
    const shown = JSON.stringify(mouse);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#mouse = mouse;
    const running = mouse?.running ?? false;
    const [pressed, next] = running ? [this.#run, this.#stop] : [this.#stop, this.#run];
    next.disabled = false;
    if (document.activeElement === pressed) next.focus(); // else the focus would be lost
    pressed.disabled = true;
    set(this.#form, "data-running", running);
    write(this.#form, ".says", mouse ? `${mouse.strategy}: ${mouse.says || (running ? "searching" : "ended")}` : "");
  }
}
