// @ts-check
// The shared worker that receives the server's events for all windows of a browser.

import { EventStream } from "./events.js";

/** @typedef {import("./events.js").Message} Message */

/** The visible windows. @type {Set<MessagePort>} */
const visible = new Set();
/** The newest message about the connection and the newest event. @type {Message[]} */
let newest = [];

const stream = new EventStream((message) => {
  newest = "event" in message ? [{ connected: true }, message] : [message];
  for (const port of visible) send(port, message);
});

/** @param {MessagePort} port @param {Message} message */
const send = (port, message) => port.postMessage({ ...message, windows: visible.size });

/** @param {MessageEvent} event */
const connect = ({ ports: [port] }) => {
  port.onmessage = ({ data: isVisible }) => {
    if (isVisible) {
      visible.add(port);
      if (stream.isOpen) for (const message of newest) send(port, message);
      else stream.open();
    } else if (visible.delete(port) && visible.size === 0) {
      stream.close();
      newest = [];
    }
  };
};
/** @type {any} */ (globalThis).onconnect = connect;
