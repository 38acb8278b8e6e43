// @ts-check
// A few words for what every part of the page does with elements.

/**
 * The element of a selector, which the page is known to have.
 * @template {Element} T
 * @param {ParentNode} root @param {string} selector @param {new () => T} type @returns {T}
 */
export function part(root, selector, type) {
    const element = root.querySelector(selector);
    if (element instanceof type) return element;
    throw new Error(`no ${selector} in the page`);
}

/** A copy of a template's element. @param {string} id */
export function copy(id) {
    const template = part(document, `#${id}`, HTMLTemplateElement);
    return /** @type {HTMLElement} */ (template.content.firstElementChild?.cloneNode(true));
}

/** Writes a text, unless it stands there. @param {Element} element @param {string} text */
export function write(element, text) {
    if (element.textContent !== text) element.textContent = text;
}

/** @param {number} number */
export const grouped = (number) => number.toLocaleString("en");

/** @param {number} count @param {string} thing */
export const counted = (count, thing) => `${grouped(count)} ${thing}${count === 1 ? "" : "s"}`;

/** The next frame. @returns {Promise<number>} */
export const frame = () => new Promise((resolve) => requestAnimationFrame(resolve));

/** @param {number} milliseconds */
export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Says what went wrong, until it is dismissed or something else does. @param {unknown} problem */
export function report(problem) {
    if (problem instanceof DOMException && problem.name === "AbortError") return;
    const lost = problem instanceof TypeError;
    write(part(document, "#problem span", HTMLElement),
        lost ? "The simulator does not answer." : String(/** @type {Error} */ (problem).message ?? problem));
    part(document, "#problem", HTMLElement).hidden = false;
}

export function clearProblem() {
    part(document, "#problem", HTMLElement).hidden = true;
}
