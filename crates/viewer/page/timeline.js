// @ts-check
// Which state of the history is wanted: the newest while following, one that was chosen, or one after
// the other while playing. States are counted from 0 here and from 1 for the user.

import { grouped, part, set, write } from "./dom.js";

/** How many states a shifted arrow key goes. */
const STRIDE = 10;
/** Milliseconds between looks at how many states there are, while the shown one stays. */
const COUNT = 200;

export class Timeline {
  following = true;
  playing = false;
  states = 0;
  #chosen = 0;
  #timer = 0;
  #panel;
  #live;
  #changed;
  #slider;
  #jump;
  #speed;
  #buttons;

  /** @param {HTMLElement} panel @param {boolean} live whether states may follow @param {() => void} changed */
  constructor(panel, live, changed) {
    this.#panel = panel;
    this.#live = live;
    this.#changed = changed;
    this.#slider = part(panel, "[name=slider]", HTMLInputElement);
    this.#jump = part(panel, "[name=jump]", HTMLInputElement);
    this.#speed = part(panel, "[name=speed]", HTMLSelectElement);
    /** @param {string} name @param {() => void} press */
    const button = (name, press) => {
      const element = part(panel, `button[name=${name}]`, HTMLButtonElement);
      element.onclick = press;
      return element;
    };
    this.#buttons = {
      first: button("first", () => this.go(0)),
      back: button("back", () => this.go(this.wanted - 1)),
      play: button("play", () => (this.playing ? this.go(this.wanted) : this.#play())),
      on: button("on", () => this.go(this.wanted + 1)),
      follow: button("follow", () => this.follow()),
    };
    if (!live) write(panel, "[name=follow]", "Last");
    this.#slider.oninput = () => this.go(this.#slider.valueAsNumber);
    part(panel, ".jump", HTMLFormElement).onsubmit = (event) => {
      event.preventDefault();
      const text = this.#jump.value.replace(/[g\s]/g, ""); // g leads here, and may be pressed here again
      const number = /^(\d+|\d{1,3}(,\d{3})+)$/.test(text) ? Number(text.replaceAll(",", "")) : 0;
      const isThere = number > 0 && number <= this.states;
      this.#refuse(text && !isThere ? `a number from 1 to ${grouped(this.states)}` : "");
      if (!isThere) return;
      this.go(number - 1);
      this.#jump.value = "";
    };
    this.#jump.oninput = () => this.#refuse("");
  }

  /** Says what the field expects, or nothing. @param {string} expected */
  #refuse(expected) {
    this.#jump.setCustomValidity(expected && `expected ${expected}`);
    this.#jump.reportValidity();
  }

  /** The state to show, -1 if there is none. */
  get wanted() {
    return this.following ? this.states - 1 : Math.min(this.#chosen, this.states - 1);
  }

  /** Another run: follows it. @param {number} states */
  begin(states) {
    this.states = states;
    this.follow();
  }

  /** @param {number} states */
  grow(states) {
    if (states <= this.states) return; // a word that was overtaken
    this.states = states;
    if (this.following) return this.#changed();
    this.#timer ||= setTimeout(() => {
      this.#timer = 0;
      this.show();
    }, COUNT);
  }

  follow() {
    this.playing = false;
    this.#want(true, 0);
  }

  /** @param {number} at */
  go(at) {
    this.playing = false;
    if (this.states > 0) this.#want(false, at); // else the first one will be followed
  }

  /** @param {boolean} following @param {number} at */
  #want(following, at) {
    this.following = following;
    this.#chosen = Math.max(0, Math.min(at, this.states - 1));
    this.show();
    this.#changed();
  }

  /** From the shown state on, or from the first if the last is shown. */
  #play() {
    let from = this.wanted === this.states - 1 ? 0 : this.wanted;
    let [speed, began] = [0, 0];
    this.playing = true;
    this.#want(false, from);
    /** @param {number} now */
    const tick = (now) => {
      if (!this.playing) return;
      if (speed !== Number(this.#speed.value)) {
        [speed, began, from] = [Number(this.#speed.value), now, this.wanted];
      }
      const at = from + Math.floor(((now - began) * speed) / 1000);
      if (at >= this.states - 1) return this.#live ? this.follow() : this.go(at);
      if (at !== this.wanted) this.#want(false, at);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** Whether the key means something here. @param {KeyboardEvent} event */
  press({ key, shiftKey }) {
    const step = shiftKey ? STRIDE : 1;
    if (key === "ArrowLeft") this.go(this.wanted - step);
    else if (key === "ArrowRight") this.go(this.wanted + step);
    else if (key === "Home") this.go(0);
    else if (key === "End") this.follow();
    else if (key === " ") this.#buttons.play.click();
    else if (key === "g") this.#jump.focus();
    else return false;
    return true;
  }

  /** Writes where the history stands. */
  show() {
    const { states, wanted, following, playing } = this;
    const { first, back, play, on, follow } = this.#buttons;
    const place = states ? `state ${grouped(wanted + 1)} of ${grouped(states)}` : "no state yet";
    write(this.#panel, ".place", place);
    set(this.#slider, "max", Math.max(0, states - 1));
    set(this.#slider, "aria-valuetext", place);
    this.#slider.value = `${Math.max(0, wanted)}`;
    set(follow, "aria-pressed", following);
    set(play, "aria-pressed", playing);
    for (const control of [this.#slider, this.#jump, play]) control.disabled = states === 0;
    first.disabled = back.disabled = wanted <= 0;
    on.disabled = wanted >= states - 1;
    set(this.#panel, "data-states", states);
    set(this.#panel, "data-following", following);
  }
}
