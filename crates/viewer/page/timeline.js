// @ts-check
// Which state of the history is wanted: the newest while following, one that was chosen, or one
// after the other while playing. States are counted from 0 here and from 1 for the user.

import { grouped, part, write } from "./dom.js";

/** How many states a shifted arrow key goes. */
const STRIDE = 10;

export class Timeline {
    following = true;
    playing = false;
    states = 0;
    #chosen = 0;
    #live;
    #element;
    #changed;
    #slider;
    #place;
    #jump;
    #speed;
    #buttons;

    /**
     * @param {HTMLElement} element the panel
     * @param {boolean} live whether states may follow
     * @param {() => void} changed another state is wanted
     */
    constructor(element, live, changed) {
        this.#live = live;
        this.#element = element;
        this.#changed = changed;
        this.#slider = part(element, "[name=slider]", HTMLInputElement);
        this.#place = part(element, ".place", HTMLElement);
        this.#jump = part(element, "[name=jump]", HTMLInputElement);
        this.#speed = part(element, "[name=speed]", HTMLSelectElement);
        /** @param {string} name */
        const button = (name) => part(element, `button[name=${name}]`, HTMLButtonElement);
        const [first, back, play, on, follow] = ["first", "back", "play", "on", "follow"].map(button);
        this.#buttons = { first, back, play, on, follow };
        if (!live) write(follow, "Last");
        first.onclick = () => this.go(0);
        back.onclick = () => this.go(this.wanted - 1);
        play.onclick = () => (this.playing ? this.pause() : this.play());
        on.onclick = () => this.go(this.wanted + 1);
        follow.onclick = () => this.follow();
        this.#slider.oninput = () => this.go(this.#slider.valueAsNumber);
        part(element, ".jump", HTMLFormElement).onsubmit = (event) => {
            event.preventDefault();
            const number = parseInt(this.#jump.value.replace(/[^0-9]/g, ""), 10);
            if (number > 0) this.go(number - 1);
            this.#jump.value = "";
        };
    }

    /** The state to show, -1 before the first. */
    get wanted() {
        return this.following ? this.states - 1 : Math.min(this.#chosen, this.states - 1);
    }

    /** Another run: follows it. @param {number} states */
    begin(states) {
        this.playing = false;
        this.following = true;
        this.states = states;
        this.#changed();
    }

    /** @param {number} states */
    grow(states) {
        if (states === this.states) return;
        this.states = states;
        this.#changed();
    }

    /** @param {number} at */
    go(at) {
        this.playing = false;
        this.#goTo(at);
    }

    /** @param {number} at */
    #goTo(at) {
        this.following = false;
        this.#chosen = Math.max(0, Math.min(at, this.states - 1));
        this.#changed();
    }

    follow() {
        this.playing = false;
        this.following = true;
        this.#changed();
    }

    pause() {
        this.go(this.wanted);
    }

    /** From the shown state on, or from the first if the last is shown. */
    play() {
        if (this.states === 0) return;
        this.playing = true;
        let from = this.wanted === this.states - 1 ? 0 : this.wanted;
        let speed = 0;
        let began = 0;
        this.#goTo(from);
        /** @param {number} now */
        const tick = (now) => {
            if (!this.playing) return;
            if (speed !== Number(this.#speed.value)) {
                [speed, began, from] = [Number(this.#speed.value), now, this.wanted];
            }
            const at = from + Math.floor(((now - began) * speed) / 1000);
            if (at >= this.states - 1) return this.#live ? this.follow() : this.go(at);
            if (at !== this.wanted) this.#goTo(at);
            requestAnimationFrame(tick);
        };
        requestAnimationFrame(tick);
    }

    /** Whether the key means something here. @param {KeyboardEvent} event */
    press(event) {
        const step = event.shiftKey ? STRIDE : 1;
        if (event.key === "ArrowLeft") this.go(this.wanted - step);
        else if (event.key === "ArrowRight") this.go(this.wanted + step);
        else if (event.key === "Home") this.go(0);
        else if (event.key === "End") this.follow();
        else if (event.key === " ") this.#buttons.play.click();
        else if (event.key === "g") this.#jump.focus();
        else return false;
        return true;
    }

    /** Writes where the history stands. */
    show() {
        const { states, wanted, following, playing } = this;
        const { first, back, play, on, follow } = this.#buttons;
        const empty = states === 0;
        write(this.#place, empty ? "no state yet" : `state ${grouped(wanted + 1)} of ${grouped(states)}`);
        const max = String(Math.max(0, states - 1));
        if (this.#slider.max !== max) this.#slider.max = max;
        this.#slider.value = String(Math.max(0, wanted));
        this.#slider.setAttribute("aria-valuetext", this.#place.textContent ?? "");
        for (const control of [this.#slider, this.#jump, play]) control.disabled = empty;
        first.disabled = back.disabled = wanted <= 0;
        on.disabled = wanted >= states - 1;
        follow.setAttribute("aria-pressed", String(following));
        play.setAttribute("aria-pressed", String(playing));
        play.setAttribute("aria-label", playing ? "Pause" : "Play");
        this.#element.dataset.states = String(states);
        this.#element.dataset.following = String(following);
    }
}
