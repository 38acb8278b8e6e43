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
 * @param {(connected: boolean) => void} onConnection
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
      onConnection(false);
      if (opened.readyState === EventSource.CLOSED) setTimeout(() => stream === opened && open(), RETRY);
    };
  };
  document.addEventListener("visibilitychange", open);
  open();
}
