// @ts-check
// The stream of server-sent events, which is open while the tab is visible.

/** Milliseconds before a stream is reopened if the browser does not reconnect by itself. */
const RETRY = 2000;

/**
 * @param {(event: import("./api.js").ServerEvent) => void} onEvent
 * @param {(connected: boolean) => void} onConnection
 */
export function listen(onEvent, onConnection) {
  /** @type {EventSource | undefined} */
  let stream;
  const open = () => {
    stream?.close();
    if (document.hidden) return;
    const opened = new EventSource("/events");
    stream = opened;
    opened.onmessage = ({ data }) => onEvent(JSON.parse(data));
    opened.onopen = () => onConnection(true);
    opened.onerror = () => {
      onConnection(false);
      if (opened.readyState === EventSource.CLOSED) setTimeout(() => stream === opened && open(), RETRY);
    };
  };
  document.addEventListener("visibilitychange", open);
  open();
}
