// @ts-check
// Runs a bundled mouse, which comes through the same door as any client.

import * as api from "./api.js";
import { clearProblem, part, report, write } from "./dom.js";

export class RunForm {
    #form;
    #run;
    #stop;
    #says;

    /** @param {HTMLElement} panel @param {api.PageFacts["strategies"]} strategies */
    constructor(panel, strategies) {
        const form = part(panel, "form.run", HTMLFormElement);
        const strategy = part(form, "[name=strategy]", HTMLSelectElement);
        const pace = part(form, "[name=pace]", HTMLSelectElement);
        this.#form = form;
        this.#run = part(form, "[name=run]", HTMLButtonElement);
        this.#stop = part(form, "[name=stop]", HTMLButtonElement);
        this.#says = part(form, ".says", HTMLElement);
        strategy.replaceChildren(...strategies.map(({ name }) => new Option(name, name)));
        const tellAbout = () => write(part(form, ".about", HTMLElement), strategies[strategy.selectedIndex]?.about ?? "");
        strategy.onchange = tellAbout;
        tellAbout();
        form.onsubmit = (event) => {
            event.preventDefault();
            clearProblem();
            api.runMouse(strategy.value, Number(pace.value)).catch(report);
        };
        this.#stop.onclick = () => api.stopMouse().catch(report);
        form.hidden = false;
        this.show(null);
    }

    /** @param {api.MouseRun | null} mouse */
    show(mouse) {
        const running = mouse?.running ?? false;
        // A disabled button would lose the keyboard's focus to nowhere.
        if (running && document.activeElement === this.#run) this.#stop.disabled = false, this.#stop.focus();
        if (!running && document.activeElement === this.#stop) this.#run.disabled = false, this.#run.focus();
        this.#run.disabled = running;
        this.#stop.disabled = !running;
        this.#form.dataset.running = String(running);
        write(this.#says, !mouse ? "" : mouse.says ? `${mouse.strategy}: ${mouse.says}` : running ? `${mouse.strategy} is searching` : "");
    }
}
