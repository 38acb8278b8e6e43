// @ts-check
// DOM helpers. They skip unchanged values, since writing even the same value triggers a layout.

/** Milliseconds for which a button says that it has copied something. */
const COPIED_TIME = 1500;

/**
 * Returns the first element that matches a selector. Throws an error if there is none.
 * @template {Element} [T=HTMLElement]
 * @param {ParentNode} root
 * @param {string} selector
 * @param {new () => T} [type]
 * @returns {T}
 */
export function query(root, selector, type) {
  const element = root.querySelector(selector);
  if (element instanceof (type ?? HTMLElement)) return /** @type {T} */ (element);
  throw new Error(`no element matches ${selector}`);
}

/** @param {string} id */
export function cloneTemplate(id) {
  const { content } = query(document, `#${id}`, HTMLTemplateElement);
  return /** @type {HTMLElement} */ (content.firstElementChild?.cloneNode(true));
}

/** Sets the text of an element. Returns the element. @param {ParentNode} root @param {string} selector @param {unknown} text */
export function setText(root, selector, text) {
  const element = query(root, selector);
  if (element.textContent !== String(text)) element.textContent = String(text);
  return element;
}

/** @param {Element} element @param {Record<string, unknown>} attributes */
export function setAttributes(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
  }
}

/** Creates an element of an SVG. @param {string} tag @param {Record<string, unknown>} attributes */
export function svgElement(tag, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  setAttributes(element, attributes);
  return /** @type {SVGElement} */ (element);
}

/**
 * Sets what a click on a button does. Returns the button.
 * @param {ParentNode} root @param {string} name @param {((event: MouseEvent) => unknown) | null} onClick
 */
export function buttonOf(root, name, onClick) {
  const button = query(root, `button[name=${name}]`, HTMLButtonElement);
  button.onclick = onClick;
  return button;
}

/** @param {number} number */
export const formatNumber = (number) => number.toLocaleString("en");

/** Formats a number in at most seven characters: from a million on, as `1.234M`. @param {number} number */
export const formatCount = (number) =>
  number < 1e6 ? formatNumber(number) : number.toLocaleString("en", { notation: "compact", maximumSignificantDigits: 4 });

/** Formats a size, such as `98 kB` or `1.2 MB`. @param {number} bytes */
export function formatBytes(bytes) {
  const power = bytes < 999_500 ? 1 : bytes < 999_500_000 ? 2 : 3;
  const number = bytes / 1000 ** power;
  return `${number.toFixed(number < 9.95 ? 1 : 0)} ${["kB", "MB", "GB"][power - 1]}`;
}

/** Formats a time: `0.012 s`, `145.600 s`, `17:08` or `1:02:03`. @param {number} time in s */
export function formatTime(time) {
  if (time < 999.9995) return `${time.toFixed(3)} s`;
  const seconds = Math.round(time);
  const [hours, minutes] = [Math.floor(seconds / 3600), Math.floor(seconds / 60) % 60];
  /** @param {number} number */
  const twoDigits = (number) => `${number}`.padStart(2, "0");
  return `${hours ? `${hours}:${twoDigits(minutes)}` : minutes}:${twoDigits(seconds % 60)}`;
}

/** @param {number} count @param {string} noun */
export const pluralize = (count, noun) => `${formatNumber(count)} ${noun}${count === 1 ? "" : "s"}`;

export const nextFrame = () => new Promise(requestAnimationFrame);

/** @param {number} milliseconds */
export const sleep = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/**
 * Returns a function that runs a task, one run at a time. The task is repeated if the function was called meanwhile.
 * @param {() => Promise<unknown>} task
 */
export function oneAtATime(task) {
  let [isStale, isRunning] = [false, false];
  return async () => {
    isStale = true;
    if (isRunning) return;
    isRunning = true;
    while (isStale) {
      isStale = false;
      await task();
    }
    isRunning = false;
  };
}

/** Returns a value that was stored in this tab. Pages in a sandbox have no storage. @param {string} key */
export function recall(key) {
  try {
    return sessionStorage.getItem(key);
  } catch {
    return null;
  }
}

/** Stores a value in this tab, if possible. @param {string} key @param {string} value */
export function remember(key, value) {
  try {
    sessionStorage.setItem(key, value);
  } catch {
    // The value lasts until the page is closed.
  }
}

/** Shows an error until the user dismisses it or starts another action. @param {unknown} error */
export function showError(error) {
  if (!(error instanceof Error) || error.name === "AbortError") return;
  // `fetch` fails with a TypeError when there is no response. If the connection is lost, the page says so already.
  if (error instanceof TypeError && !query(document, "#offline").hidden) return;
  const text = error instanceof TypeError ? "No response from the simulator (is it still running?)" : error.message;
  setText(document, "#error span", text);
  query(document, "#error").hidden = false;
}

export function clearError() {
  query(document, "#error").hidden = true;
}

/**
 * Asks for confirmation of an action.
 * @param {string} action
 * @param {string} name
 * @param {number} states the number of states that are deleted by a reset of the simulation
 * @param {{ warning?: string, mouse?: string }} [options] a further sentence, and the mouse that may run afterwards
 * @returns {Promise<"" | "confirm" | "run">}
 */
export function confirmAction(action, name, states, { warning = "", mouse } = {}) {
  const dialog = query(document, "#confirm", HTMLDialogElement);
  for (const element of dialog.querySelectorAll(".action")) element.textContent = action;
  setText(dialog, ".name", name);
  setText(dialog, ".states", pluralize(states, "state"));
  query(dialog, ".deletion").hidden = states === 0;
  setText(dialog, ".warning", warning);
  const run = query(dialog, "[value=run]");
  run.hidden = mouse === undefined;
  run.textContent = `${action} and run ${mouse}`;
  query(dialog, "[value=confirm]").classList.toggle("primary", mouse === undefined);
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(/** @type {"" | "confirm" | "run"} */ (dialog.returnValue));
  });
}

/** Returns how far a key moves in a list, or undefined if it does not. @param {string} key @returns {number | undefined} */
export const listStep = (key) =>
  ({ ArrowDown: 1, ArrowUp: -1, PageDown: 8, PageUp: -8, Home: -Infinity, End: Infinity })[key];

/** Copies a text and marks a button for a moment. Rejects if the browser does not allow it. @param {HTMLElement} button @param {string} text */
export async function copy(button, text) {
  await navigator.clipboard.writeText(text);
  button.classList.add("copied");
  await sleep(COPIED_TIME);
  button.classList.remove("copied");
}
