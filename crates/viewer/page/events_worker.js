// @ts-check
// The shared worker that receives the server's events for all windows of a browser.

import { EventStream } from "./events.js";

/** @typedef {import("./events.js").Message} Message */

/** The time in ms without an event after which all windows receive the newest one. Longer than between events of a fast search. */
const QUIET = 150;

/** The visible windows. The first one receives the next event. @type {Set<MessagePort>} */
const visible = new Set();
/** The visible windows that have not received the newest event. @type {MessagePort[]} */
let others = [];
/** The newest message about the connection and the newest event. @type {Message[]} */
let newest = [];
let timer = 0;

const stream = new EventStream((message) => {
  clearTimeout(timer);
  if ("event" in message) {
    newest = [{ connected: true }, message];
    const [first, ...rest] = visible;
    visible.delete(first);
    visible.add(first);
    send([first], message);
    others = rest;
    timer = setTimeout(sendToOthers, QUIET);
  } else {
    sendToOthers();
    newest = [message];
    send(visible, message);
  }
});

function sendToOthers() {
  send(others.filter((port) => visible.has(port)), newest[newest.length - 1]);
  others = [];
}

/** @param {Iterable<MessagePort>} ports @param {Message} message */
function send(ports, message) {
  for (const port of ports) port.postMessage({ ...message, windows: visible.size });
}

/** @param {MessageEvent} event */
const connect = ({ ports: [port] }) => {
  port.onmessage = ({ data: isVisible }) => {
    if (isVisible) {
      visible.add(port);
      if (stream.isOpen) for (const message of newest) send([port], message);
      else stream.open();
    } else if (visible.delete(port) && visible.size === 0) {
      stream.close();
      clearTimeout(timer);
      others = [];
      newest = [];
    }
  };
};
/** @type {any} */ (globalThis).onconnect = connect;
