// @ts-check
// A few words for what every part of the page does with elements. What is already so is not written
// again: even the same value costs a layout.

/**
 * The element of a selector, which the page is known to have.
 * @template {Element} [T=HTMLElement]
 * @param {ParentNode} root
 * @param {string} selector
 * @param {new () => T} [type]
 * @returns {T}
 */
export function part(root, selector, type) {
  const element = root.querySelector(selector);
  if (element instanceof (type ?? HTMLElement)) return /** @type {T} */ (element);
  throw new Error(`no ${selector} in the page`);
}

/** A copy of a template's element. @param {string} id */
export function copy(id) {
  const { content } = part(document, `#${id}`, HTMLTemplateElement);
  return /** @type {HTMLElement} */ (content.firstElementChild?.cloneNode(true));
}

/** Writes the text of a part. @param {ParentNode} root @param {string} selector @param {unknown} text */
export function write(root, selector, text) {
  const element = part(root, selector);
  if (element.textContent !== String(text)) element.textContent = String(text);
}

/** @param {Element} element @param {string} attribute @param {unknown} value */
export function set(element, attribute, value) {
  if (element.getAttribute(attribute) !== String(value)) element.setAttribute(attribute, String(value));
}

/** @param {number} number */
export const grouped = (number) => number.toLocaleString("en");

/** @param {number} count @param {string} thing */
export const counted = (count, thing) => `${grouped(count)} ${thing}${count === 1 ? "" : "s"}`;

/** The next frame. */
export const frame = () => new Promise(requestAnimationFrame);

/** @param {number} milliseconds */
export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Says what went wrong, until it is dismissed or something is tried anew. @param {unknown} problem */
export function report(problem) {
  if (!(problem instanceof Error) || problem.name === "AbortError") return;
  write(document, "#problem span", problem instanceof TypeError ? "The simulator does not answer." : problem.message);
  part(document, "#problem").hidden = false;
}

export function clearProblem() {
  part(document, "#problem").hidden = true;
}

/** Asks before states are deleted. @param {string} deed @param {string} name @param {number} states @returns {Promise<boolean>} */
export function confirmed(deed, name, states) {
  const dialog = part(document, "#confirm", HTMLDialogElement);
  for (const place of dialog.querySelectorAll(".deed")) place.textContent = deed;
  write(dialog, ".name", name);
  write(dialog, ".states", counted(states, "state"));
  dialog.returnValue = "";
  dialog.showModal();
  return new Promise((resolve) => {
    dialog.onclose = () => resolve(dialog.returnValue === "serve");
  });
}
