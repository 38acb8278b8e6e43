// @ts-check
// The slider for the pace, which governs a running mouse and the playback of states.

import { formatNumber, query, setAttributes } from "./dom.js";

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

export class PaceSlider {
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
  async #inform() {
    if (!this.#send || this.#sending) return;
    this.#sending = true;
    let sent = NaN;
    while (sent !== this.rate) {
      sent = this.rate;
      await this.#send(Number.isFinite(sent) ? sent : null);
    }
    this.#sending = false;
  }
}
