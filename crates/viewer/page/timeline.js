// @ts-check
// The player controls, which select the state to show. While following, the newest state is shown. States are
// numbered from 0, as in all outputs.

import * as api from "./api.js";
import { Axis } from "./axis.js";
import { buttonOf, formatNumber, oneAtATime, query, setAttributes, setText, showError } from "./dom.js";

/** Step of the arrow keys with Shift, in states. */
const LARGE_STEP = 10;
/** Milliseconds between updates of the number of states while not following. */
const COUNT_INTERVAL = 200;
/** States per second at ×1. */
const BASE_RATE = 20;
/** The factors on the slider, with their names. @type {[number, string][]} */
const FACTORS = [
  [1 / 4, "×¼"],
  [1 / 2, "×½"],
  .../** @type {[number, string][]} */ ([1, 2, 4, 8, 16, 32, 64].map((factor) => [factor, `×${factor}`])),
  [Infinity, "no limit"],
];
/** Without a limit, a playback takes at most this many seconds, but at least at this rate. */
const UNLIMITED_PLAYBACK = { seconds: 3, minRate: 2560 };

export class Timeline {
  following = true;
  /** True if the user has chosen the shown state, even the newest one. */
  isChosen = false;
  playing = false;
  states = 0;
  /** Called when the user or playback moves to another state. */
  onMove = () => {};
  #selected = 0;
  #timer = 0;
  #panel;
  #live;
  #onChange;
  #slider;
  #jump;
  #buttons;

  /** @param {HTMLElement} panel @param {boolean} live true if the run may grow @param {() => void} onChange */
  constructor(panel, live, onChange) {
    this.#panel = panel;
    this.#live = live;
    this.#onChange = onChange;
    this.#slider = query(panel, "[name=slider]", HTMLInputElement);
    this.#jump = query(panel, "[name=jump]", HTMLInputElement);
    this.axis = new Axis(panel);
    this.pace = new PaceSlider(panel, live ? (rate) => api.setPace(rate).catch(showError) : undefined);
    this.#buttons = {
      first: buttonOf(panel, "first", () => this.seek(0)),
      previous: buttonOf(panel, "previous", () => this.seek(this.target - 1)),
      play: buttonOf(panel, "play", () => (this.playing ? this.seek(this.target) : this.#play())),
      next: buttonOf(panel, "next", () => this.seek(this.target + 1)),
      follow: buttonOf(panel, "follow", () => this.follow()),
    };
    if (!live) setText(panel, "[name=follow]", "Last");
    this.#slider.oninput = () => this.seek(this.#slider.valueAsNumber);
    query(panel, ".jump", HTMLFormElement).onsubmit = (event) => {
      event.preventDefault();
      const text = this.#jump.value.replace(/[g\s]/g, ""); // the shortcut g may be pressed twice
      const number = /^(\d+|\d{1,3}(,\d{3})+)$/.test(text) ? Number(text.replaceAll(",", "")) : -1;
      const isValid = number >= 0 && number < this.states;
      this.#setJumpError(text && !isValid ? `Enter a number from 0 to ${formatNumber(this.states - 1)}.` : "");
      if (!isValid) return;
      this.seek(number);
      this.#jump.value = "";
      panel.focus({ preventScroll: true }); // the next keys are shortcuts again
    };
    this.#jump.oninput = () => this.#setJumpError("");
  }

  /** @param {string} message */
  #setJumpError(message) {
    this.#jump.setCustomValidity(message);
    this.#jump.reportValidity();
  }

  /** Index of the state to show, or -1 if there are no states. */
  get target() {
    return this.following ? this.states - 1 : Math.min(this.#selected, this.states - 1);
  }

  /** Follows a new run. @param {number} states */
  start(states) {
    this.states = states;
    this.axis.start(states);
    this.playing = this.isChosen = false;
    this.#moveTo(true, 0);
  }

  /** @param {number} states */
  grow(states) {
    if (states <= this.states) return; // an older event, received late
    this.states = states;
    if (this.following) {
      this.isChosen = false;
      return this.#onChange();
    }
    this.#timer ||= setTimeout(() => {
      this.#timer = 0;
      this.show();
    }, COUNT_INTERVAL);
  }

  follow() {
    this.playing = false;
    this.isChosen = true;
    this.onMove();
    this.#moveTo(true, 0);
  }

  /** @param {number} index */
  seek(index) {
    this.onMove();
    this.moveLinked(index);
  }

  /** Moves to a state without moving other panels. @param {number} index */
  moveLinked(index) {
    this.playing = false;
    if (this.states > 0) this.#moveTo(false, index); // otherwise keep following, to show the first state
  }

  /** @param {boolean} following @param {number} index */
  #moveTo(following, index) {
    this.following = following;
    this.#selected = Math.max(0, Math.min(index, this.states - 1));
    this.show();
    this.#onChange();
  }

  /** Plays from the shown state. If the last state is shown, plays from the first state. */
  #play() {
    let from = this.target === this.states - 1 ? 0 : this.target;
    let [speed, started] = [0, 0];
    this.playing = true;
    this.onMove();
    this.#moveTo(false, from);
    /** @param {number} now */
    const tick = (now) => {
      if (!this.playing) return;
      const rate = this.pace.playbackRate(this.states);
      if (speed !== rate) [speed, started, from] = [rate, now, this.target];
      const index = from + Math.floor(((now - started) * speed) / 1000);
      if (index >= this.states - 1) return this.#live ? this.follow() : this.seek(index);
      if (index !== this.target) this.#moveTo(false, index);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey({ key, shiftKey }) {
    const step = shiftKey ? LARGE_STEP : 1;
    if (key === "ArrowLeft") this.seek(this.target - step);
    else if (key === "ArrowRight") this.seek(this.target + step);
    else if (key === "Home") this.seek(0);
    else if (key === "End") this.follow();
    else if (key === " ") this.#buttons.play.click();
    else if (key === "g") this.#jump.focus();
    else return false;
    return true;
  }

  show() {
    const { states, target, following, playing } = this;
    const { first, previous, play, next, follow } = this.#buttons;
    const position = states ? `State ${formatNumber(target)} of ${formatNumber(states - 1)}` : "No states yet";
    setText(this.#panel, ".position", position);
    setAttributes(this.#slider, { max: Math.max(0, states - 1), "aria-valuetext": position });
    this.#slider.value = `${Math.max(0, target)}`;
    this.axis.show(states, target);
    setAttributes(follow, { "aria-pressed": following });
    setAttributes(play, { "aria-pressed": playing });
    for (const control of [this.#slider, this.#jump, play]) control.disabled = states === 0;
    first.disabled = previous.disabled = target <= 0;
    next.disabled = target >= states - 1;
    setAttributes(this.#panel, { "data-states": states, "data-following": following });
  }
}

/** The slider for the pace, which governs a running mouse and the playback of states. */
class PaceSlider {
  /** States per second, or Infinity if there is no limit. */
  rate = BASE_RATE;
  #input;
  #output;
  #send;
  /** True while the server is informed of changes. */
  #sending = false;

  /**
   * @param {HTMLElement} panel
   * @param {(rate: number | null) => Promise<unknown>} [send] informs the server of a change; null means no limit
   */
  constructor(panel, send) {
    this.#input = query(panel, "[name=pace]", HTMLInputElement);
    this.#output = query(panel, ".pace output");
    this.#send = send;
    this.#input.max = `${FACTORS.length - 1}`;
    this.#input.oninput = () => {
      this.#show(FACTORS[this.#input.valueAsNumber][0] * BASE_RATE);
      void this.#inform();
    };
    // The arrow keys move this slider instead of stepping through the states.
    this.#input.onkeydown = (event) => {
      if (/^(Arrow|Page|Home|End)/.test(event.key)) event.stopPropagation();
    };
    this.#show(this.rate);
  }

  /** Shows the pace of the server, unless the user has just changed it. @param {number | null} rate */
  update(rate) {
    if (!this.#sending) this.#show(rate ?? Infinity);
  }

  /** Returns the states per second of a playback. @param {number} states the total number of states */
  playbackRate(states) {
    const { seconds, minRate } = UNLIMITED_PLAYBACK;
    return Number.isFinite(this.rate) ? this.rate : Math.max(minRate, states / seconds);
  }

  /** @param {number} rate */
  #show(rate) {
    this.rate = rate;
    const factor = rate / BASE_RATE;
    const nearest = FACTORS.findIndex(([other]) => factor <= other * Math.SQRT2);
    const isExact = FACTORS[nearest][0] === factor;
    const perSecond = Number.isFinite(rate) ? `${formatNumber(Number(rate.toPrecision(3)))}/s` : "";
    const text = isExact ? FACTORS[nearest][1] : perSecond;
    this.#input.value = `${nearest}`;
    if (this.#output.textContent !== text) this.#output.textContent = text;
    const states = perSecond && `${perSecond.replace("/s", "")} states per second`;
    setAttributes(this.#input, { "aria-valuetext": states || text, title: `Pace of the mouse and of playback: ${states || text}` });
  }

  /** Sends the newest pace, one request at a time. */
  #inform = oneAtATime(async () => {
    this.#sending = true;
    await this.#send?.(Number.isFinite(this.rate) ? this.rate : null);
    this.#sending = false;
  });
}
