// @ts-check
// The playback of fast runs: the clock, the slider in time and the speed of the playback.

import { Axis } from "./axis.js";
import { query, setAttributes, setText } from "./dom.js";

/** Steps of the arrow keys and of the arrow keys with Shift, in s. */
const [STEP, LARGE_STEP] = [0.01, 0.1];

export class FastRunPlayer {
  /** The shown time, in s. */
  time = 0;
  playing = false;
  axis;
  /** The time at which the last mouse stops, in s. */
  #end = 0;
  /** Seconds of the run per second of the playback. */
  #rate = 1;
  #area;
  #slider;
  #play;
  #onTime;

  /** @param {HTMLElement} area @param {(time: number) => void} onTime shows the mice at a time */
  constructor(area, onTime) {
    this.#area = area;
    this.#onTime = onTime;
    this.axis = new Axis(area);
    this.#slider = query(area, "[name=time]", HTMLInputElement);
    this.#slider.oninput = () => this.seek(this.#slider.valueAsNumber / 1000);
    this.#play = query(area, "[name=drive]", HTMLButtonElement);
    this.#play.onclick = () => (this.playing ? this.pause() : this.#start());
    query(area, "[name=restart]").onclick = () => this.seek(0);
    for (const button of this.#rates) {
      // A click does not focus the button, so Space still plays.
      button.onmousedown = (event) => event.preventDefault();
      button.onclick = () => {
        this.#rate = Number(button.value);
        this.#show();
      };
    }
  }

  get #rates() {
    return /** @type {NodeListOf<HTMLButtonElement>} */ (this.#area.querySelectorAll("[name=rate]"));
  }

  /** Sets the duration of the longest shown run. @param {number} end in s */
  setEnd(end) {
    this.#end = end;
    this.axis.start(Math.ceil(end * 1000) + 1);
    this.#moveTo(this.time);
  }

  /** Shows a time, in whole milliseconds like the clock, and stops the playback. @param {number} time in s */
  seek(time) {
    this.playing = false;
    this.#moveTo(Math.round(time * 1000) / 1000);
  }

  pause() {
    this.seek(this.time);
  }

  /** Plays from the shown time, or from the beginning if all mice have stopped. */
  #start() {
    if (this.#end === 0) return;
    let [from, started, rate] = [this.time < this.#end ? this.time : 0, performance.now(), this.#rate];
    this.playing = true;
    const tick = () => {
      if (!this.playing) return;
      const now = performance.now();
      if (rate !== this.#rate) [from, started, rate] = [this.time, now, this.#rate];
      const time = from + ((now - started) / 1000) * rate;
      if (time >= this.#end) return this.seek(this.#end);
      this.#moveTo(time);
      requestAnimationFrame(tick);
    };
    tick();
  }

  /** @param {number} time in s */
  #moveTo(time) {
    this.time = Math.min(Math.max(0, time), this.#end);
    this.#show();
    this.#onTime(this.time);
  }

  #show() {
    const [time, end] = [this.time, this.#end];
    const clock = `${time.toFixed(3)} s`;
    setText(this.#area, ".clock", clock);
    setText(this.#area, ".end", end > 0 ? `of ${end.toFixed(3)} s` : "");
    setAttributes(this.#slider, { max: Math.ceil(end * 1000), "aria-valuetext": clock });
    this.#slider.value = `${Math.round(time * 1000)}`;
    this.axis.show(Math.ceil(end * 1000) + 1, time * 1000);
    setAttributes(this.#play, { "aria-pressed": this.playing });
    this.#slider.disabled = this.#play.disabled = end === 0;
    query(this.#area, "[name=restart]", HTMLButtonElement).disabled = time === 0;
    for (const button of this.#rates) setAttributes(button, { "aria-pressed": Number(button.value) === this.#rate });
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey({ key, shiftKey }) {
    const step = shiftKey ? LARGE_STEP : STEP;
    if (key === "ArrowLeft") this.seek(this.time - step);
    else if (key === "ArrowRight") this.seek(this.time + step);
    else if (key === "Home") this.seek(0);
    else if (key === "End") this.seek(this.#end);
    else if (key === " ") this.#play.click();
    else return false;
    return true;
  }
}
