// @ts-check
// The stream of the server's events. All windows of a browser share one stream, because a browser opens only six
// connections to a server.

/** @typedef {import("./api.js").ServerEvent} ServerEvent */
/** @typedef {({ event: ServerEvent } | { connected: boolean, reason?: string }) & { windows?: number }} Message the reason is the server's, if it refuses */

/** The server sends an event at least every 10 s. Without one for this time in ms, the connection is lost. */
const TIMEOUT = 30_000;
/** The delay in ms before connecting again to a server that has refused the connection. */
const RETRY = 2000;

/** Windows that take turns pause longer by this factor, because each finds the processor's caches filled by the others. */
const TURN_FACTOR = 1.5;

/** The number of visible windows of this browser that show the server. */
let windows = 1;

/** Returns the factor by which a window extends its pauses, so that all windows slow the search no more than a single one. */
export const drawFactor = () => (windows > 1 ? TURN_FACTOR * windows : 1);

/** A stream of events, which connects again when the connection is lost. */
export class EventStream {
  /** @type {EventSource | undefined} */
  #source;
  #timer = 0;
  #onMessage;

  /** @param {(message: Message) => void} onMessage */
  constructor(onMessage) {
    this.#onMessage = onMessage;
  }

  get isOpen() {
    return this.#source !== undefined;
  }

  open() {
    this.close();
    const source = new EventSource("/events");
    this.#source = source;
    this.#expectEvent();
    source.onmessage = ({ data }) => {
      this.#expectEvent();
      this.#onMessage({ event: JSON.parse(data) });
    };
    source.onopen = () => this.#onMessage({ connected: true });
    source.onerror = () => {
      if (source.readyState !== EventSource.CLOSED) return this.#onMessage({ connected: false });
      setTimeout(() => this.#source === source && this.open(), RETRY);
      refusal().then((reason) => this.#source === source && this.#onMessage({ connected: false, reason }));
    };
  }

  close() {
    this.#source?.close();
    this.#source = undefined;
    clearTimeout(this.#timer);
  }

  #expectEvent() {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.#onMessage({ connected: false });
      this.open();
    }, TIMEOUT);
  }
}

/** Returns the text of the server's error response, which an `EventSource` does not provide. */
async function refusal() {
  const abort = new AbortController();
  const response = await fetch("/events", { signal: abort.signal }).catch(() => null);
  const text = response && !response.ok ? await response.text() : "";
  abort.abort();
  return text;
}

/**
 * Receives messages while the window is visible.
 * @param {(event: ServerEvent) => void} onEvent
 * @param {(connected: boolean, reason?: string) => void} onConnection
 */
export function listen(onEvent, onConnection) {
  /** @param {Message} message */
  const onMessage = (message) => {
    windows = message.windows ?? 1;
    if ("event" in message) onEvent(message.event);
    else onConnection(message.connected, message.reason);
  };
  const show = subscribe(onMessage);
  const report = () => show(!document.hidden);
  document.addEventListener("visibilitychange", report);
  addEventListener("pageshow", report);
  addEventListener("pagehide", () => show(false));
  report();
}

/**
 * Returns a function that begins or ends the reception of messages.
 * @param {(message: Message) => void} onMessage
 * @returns {(isVisible: boolean) => void}
 */
function subscribe(onMessage) {
  if (!("SharedWorker" in globalThis)) {
    const stream = new EventStream(onMessage);
    return (isVisible) => {
      if (!isVisible) stream.close();
      else if (!stream.isOpen) stream.open();
    };
  }
  const worker = new SharedWorker("/events_worker.js", { type: "module" });
  worker.onerror = () => onMessage({ connected: false });
  worker.port.onmessage = ({ data }) => onMessage(data);
  return (isVisible) => worker.port.postMessage(isVisible);
}
