// @ts-check
// The stream of server-sent events, which is open while the tab is visible.

/** Milliseconds before a stream is reopened if the browser does not reconnect by itself. */
const RETRY = 2000;
/**
 * Milliseconds without an event before the connection counts as lost. The server sends an event at least every 10
 * seconds.
 */
const TIMEOUT = 30_000;

/**
 * @param {(event: import("./api.js").ServerEvent) => void} onEvent
 * @param {(connected: boolean, reason?: string) => void} onConnection the reason is the server's, if it refuses
 */
export function listen(onEvent, onConnection) {
  /** @type {EventSource | undefined} */
  let stream;
  let timer = 0;
  const expectEvent = () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      onConnection(false);
      open();
    }, TIMEOUT);
  };
  const open = () => {
    stream?.close();
    clearTimeout(timer);
    if (document.hidden) return;
    const opened = new EventSource("/events");
    stream = opened;
    expectEvent();
    opened.onmessage = ({ data }) => {
      expectEvent();
      onEvent(JSON.parse(data));
    };
    opened.onopen = () => onConnection(true);
    opened.onerror = () => {
      if (opened.readyState !== EventSource.CLOSED) return onConnection(false);
      setTimeout(() => stream === opened && open(), RETRY);
      refusal().then((reason) => stream === opened && onConnection(false, reason));
    };
  };
  document.addEventListener("visibilitychange", open);
  open();
}

/** Returns the text of the server's error response, which an `EventSource` does not provide. */
async function refusal() {
  const abort = new AbortController();
  const response = await fetch("/events", { signal: abort.signal }).catch(() => null);
  const text = response && !response.ok ? await response.text() : "";
  abort.abort();
  return text;
}
