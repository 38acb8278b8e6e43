// @ts-check
// The marks of a run's events between the chart and the slider. Events that would overlap share a mark.

import { formatNumber, query, setAttributes, svgElement } from "./dom.js";

/**
 * @typedef {import("./api.js").EventKind} EventKind
 * @typedef {{ kind: EventKind, index: number }} Event
 */

/** The text of each kind and the lane of its marks. A mark of several events has the symbol of the first kind here. */
const KINDS = /** @type {Record<EventKind, [string, number]>} */ ({
  scored: ["trial scored", 0],
  unscored: ["trial ended without a score", 0],
  run_1: ["run 1 begins", 0],
  run_2: ["run 2 begins", 0],
  goal: ["goal reached", 0],
  fast_run: ["fast run begins", 0],
  solved: ["shortest path proven", 1],
  wrong_wall: ["another wrong wall", 1],
  reset: ["put back at the start", 1],
  return: ["return run begins", 1],
  jump: ["jumped to another cell", 1],
  log: ["log lines", 2],
});
const ORDER = /** @type {EventKind[]} */ (Object.keys(KINDS));
/** The kinds that occur only in two-run trials. */
const TRIAL = ["scored", "unscored", "run_1", "run_2"];
/** The minimum distance between two marks of a lane, in pixels. */
const DISTANCES = [13, 13, 3];
/** The maximum number of events in the tooltip of a mark. */
const MAX_LINES = 8;

export class Marks {
  #axis;
  #list;
  #legend;
  #timeline;
  /** All events, in the order of their states. @type {Event[]} */
  #events = [];
  /** What the marks show. */
  #shown = "";

  /** @param {HTMLElement} panel @param {import("./timeline.js").Timeline} timeline */
  constructor(panel, timeline) {
    this.#axis = timeline.axis;
    this.#timeline = timeline;
    this.#list = query(panel, ".marks");
    this.#legend = query(panel, ".legend");
    timeline.axis.onChange.push(() => this.#layOut());
    for (const kind of ORDER) {
      const item = document.createElement("li");
      item.dataset.event = kind;
      item.append(symbol(kind), ` ${KINDS[kind][0]}`);
      this.#legend.append(item);
    }
    this.draw({ states: 0, events: [] });
  }

  /** @param {import("./api.js").RunEvents} events */
  draw({ events }) {
    this.#events = events.flatMap(({ kind, states }) => states.map((index) => ({ kind, index })));
    this.#events.sort((a, b) => a.index - b.index);
    const thinned = events.filter(({ every }) => every > 1);
    const notes = thinned.map(({ kind, every, count }) => `${KINDS[kind][0]}: only 1 in ${every} of ${formatNumber(count)} is marked`);
    setAttributes(this.#list, { title: notes.join("\n"), "aria-label": ["Events", ...notes].join(". ") });
    const found = new Set(events.map(({ kind }) => /** @type {string} */ (kind)));
    for (const kind of TRIAL) query(this.#legend, `[data-event=${kind}]`).hidden = !found.has(kind);
    this.#layOut();
  }

  /** Describes the events of a state, except those that the figures describe. @param {number} index */
  describe(index) {
    const events = this.#events.filter(({ kind, index: at }) => at === index && !["reset", "jump", "log"].includes(kind));
    return events.map(({ kind }) => KINDS[kind][0]);
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey({ key, shiftKey }) {
    const direction = { "]": 1, "}": 1, "[": -1, "{": -1 }[key];
    if (!direction) return false;
    const { target } = this.#timeline;
    const events = shiftKey || key === "{" || key === "}" ? this.#events : this.#events.filter(({ kind }) => kind !== "log");
    const next = direction > 0 ? events.find(({ index }) => index > target) : events.filter(({ index }) => index < target).at(-1);
    if (next) this.#timeline.seek(next.index);
    return true;
  }

  /** Places the marks. */
  #layOut() {
    const { width } = this.#axis;
    /** @type {Event[][]} */
    const groups = [];
    /** @type {(Event[] | undefined)[]} */
    const newest = [];
    for (const event of width > 0 ? this.#events : []) {
      const lane = KINDS[event.kind][1];
      const group = newest[lane];
      const distance = group ? (this.#axis.share(event.index) - this.#axis.share(group[0].index)) * width : Infinity;
      if (group && distance < DISTANCES[lane]) group.push(event);
      else groups.push((newest[lane] = [event]));
    }
    const shown = JSON.stringify([width, this.#axis.last, groups]);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#list.replaceChildren(...groups.map((group) => this.#mark(group)));
  }

  /** @param {Event[]} events */
  #mark(events) {
    const kind = ORDER.find((one) => events.some((event) => event.kind === one)) ?? "log";
    const lines = kind === "log" ? [describeLog(events)] : events.slice(0, MAX_LINES).map(describe);
    if (kind !== "log" && events.length > MAX_LINES) lines.push(`${formatNumber(events.length - MAX_LINES)} more`);
    const item = document.createElement("li");
    const button = document.createElement("button");
    button.append(symbol(kind));
    button.tabIndex = -1; // the keys [ and ] go from event to event
    button.title = lines.join("\n");
    setAttributes(button, { "aria-label": lines.join(", "), "data-states": events.map(({ index }) => index).join(" ") });
    button.classList.toggle("several", kind !== "log" && events.length > 1);
    button.onclick = () => {
      // Further clicks show the other events of the mark.
      const next = events.find(({ index }) => index > this.#timeline.target) ?? events[0];
      const isHere = events.some(({ index }) => index === this.#timeline.target);
      this.#timeline.seek((isHere ? next : events[0]).index);
    };
    item.className = `lane${KINDS[kind][1]}`;
    item.style.left = `${100 * this.#axis.share(events[0].index)}%`;
    item.append(button);
    return item;
  }
}

/** @param {Event} event */
const describe = ({ kind, index }) => `${KINDS[kind][0]}, state ${formatNumber(index)}`;

/** @param {Event[]} events */
function describeLog(events) {
  const [first, last] = [events[0].index, events[events.length - 1].index].map(formatNumber);
  return first === last ? `log lines, state ${first}` : `log lines, states ${first} to ${last}`;
}

/** @param {EventKind} kind */
function symbol(kind) {
  const svg = svgElement("svg", { class: `event e-${kind}` });
  svg.append(svgElement("use", { href: `#e-${kind}` }));
  return svg;
}
