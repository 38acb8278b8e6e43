// @ts-check
// The server's events, while the tab is seen.

/** Milliseconds until a stream is opened again that the browser has given up. */
const RETRY = 2000;

/**
 * @param {(event: import("./api.js").ServerEvent) => void} hear
 * @param {(connected: boolean) => void} connected
 */
export function listen(hear, connected) {
  /** @type {EventSource | undefined} */
  let stream;
  const open = () => {
    stream?.close();
    if (document.hidden) return;
    const opened = new EventSource("/events");
    stream = opened;
    opened.onmessage = ({ data }) => hear(JSON.parse(data));
    opened.onopen = () => connected(true);
    opened.onerror = () => {
      connected(false);
      if (opened.readyState === EventSource.CLOSED) setTimeout(() => stream === opened && open(), RETRY);
    };
  };
  document.addEventListener("visibilitychange", open);
  open();
}
