// @ts-check
// The visible part of a map: zoom, pan, and the coordinates along its edges.

import { buttonOf, query, setAttributes } from "./dom.js";
import { PITCH } from "./state.js";

/** The factor of the zoom buttons and keys. */
const ZOOM_STEP = 1.5;
/** The factor of the zoom per pixel of a turned wheel. */
const WHEEL_FACTOR = 1.002;
/** At the largest zoom, at least this many cells are visible in the longer direction. */
const MIN_CELLS = 4;
/** Pixels that a pressed pointer moves before it drags the map. */
const DRAG_THRESHOLD = 4;
/** Minimum distance between two coordinates, in pixels. */
const LABEL_DISTANCE = 17;
/** Minimum size of a cell whose weight and text are legible, in pixels. */
const MIN_CELL = 18;

export class Viewport {
  /** 1 shows the whole maze. */
  #zoom = 1;
  /** The point in the middle of the map, in units of the drawing. */
  #centre = { x: 0, y: 0 };
  /** @type {SVGSVGElement | null} */
  #svg = null;
  #size = { width: 1, height: 1 };
  #wallWidths;
  /** The area of the whole drawing. */
  #whole = new DOMRect();
  #map;
  #axes;
  #buttons;
  /** The pressed pointers. @type {Map<number, { x: number, y: number }>} */
  #pointers = new Map();
  #dragging = false;

  /** @param {HTMLElement} panel @param {import("./api.js").DrawingStyle} style */
  constructor(panel, style) {
    this.#wallWidths = style.walls;
    const map = query(panel, ".map");
    this.#map = map;
    this.#axes = query(map, ".axes");
    this.#buttons = {
      in: buttonOf(panel, "zoom-in", () => this.#zoomBy(ZOOM_STEP)),
      out: buttonOf(panel, "zoom-out", () => this.#zoomBy(1 / ZOOM_STEP)),
      reset: buttonOf(panel, "zoom-reset", () => this.#zoomBy(0)),
    };
    map.addEventListener("wheel", (event) => this.#handleWheel(event), { passive: false });
    map.addEventListener("pointerdown", (event) => this.#press(event));
    map.addEventListener("pointermove", (event) => this.#move(event));
    map.addEventListener("pointerup", (event) => this.#release(event));
    map.addEventListener("pointercancel", (event) => this.#release(event));
    // With two fingers, the map zooms and the page does not scroll.
    const preventScroll = (/** @type {TouchEvent} */ event) => event.touches.length > 1 && event.preventDefault();
    map.addEventListener("touchstart", preventScroll, { passive: false });
    new ResizeObserver(() => this.#show()).observe(map);
  }

  /** Shows a new drawing as a whole, or keeps the zoom if the maze has the same size. */
  /** @param {SVGSVGElement} svg @param {{ width: number, height: number }} size */
  install(svg, { width, height }) {
    const isSame = this.#svg !== null && this.#size.width === width && this.#size.height === height;
    this.#svg = svg;
    this.#size = { width, height };
    const { x, y, width: wide, height: high } = svg.viewBox.baseVal;
    this.#whole = new DOMRect(x, y, wide, high);
    this.#map.replaceChildren(svg, this.#axes);
    if (!isSame) this.#reset();
    this.#show();
  }

  /** Handles a shortcut. Returns false if the key is not a shortcut. @param {KeyboardEvent} event */
  handleKey({ key }) {
    if (key === "+" || key === "=") this.#zoomBy(ZOOM_STEP);
    else if (key === "-") this.#zoomBy(1 / ZOOM_STEP);
    else if (key === "0") this.#zoomBy(0);
    else return false;
    return true;
  }

  /** Moves the visible part so that it contains a cell. @param {number} cell y * width + x */
  reveal(cell) {
    if (!this.#svg || this.#zoom === 1) return;
    const { width, height } = this.#size;
    const x = ((cell % width) + 0.5) * PITCH;
    const y = (height - Math.floor(cell / width) - 0.5) * PITCH;
    const { width: wide, height: high } = this.#svg.viewBox.baseVal;
    const [right, down] = [Math.max(0, wide / 2 - PITCH), Math.max(0, high / 2 - PITCH)];
    this.#centre.x = clamp(this.#centre.x, x - right, x + right);
    this.#centre.y = clamp(this.#centre.y, y - down, y + down);
    this.#show();
  }

  #reset() {
    const { x, y, width, height } = this.#whole;
    this.#zoom = 1;
    this.#centre = { x: x + width / 2, y: y + height / 2 };
  }

  get #maxZoom() {
    return Math.max(1, Math.max(this.#size.width, this.#size.height) / MIN_CELLS);
  }

  /** Zooms by a factor, or to the whole maze if the factor is 0. The point under `at` stays in place. */
  /** @param {number} factor @param {{ x: number, y: number }} [at] */
  #zoomBy(factor, at) {
    const zoom = clamp(this.#zoom * factor, 1, this.#maxZoom);
    if (zoom < 1.01) this.#reset();
    else {
      const fixed = this.#point(at) ?? this.#centre;
      const share = this.#zoom / zoom;
      this.#zoom = zoom;
      this.#centre.x = fixed.x + (this.#centre.x - fixed.x) * share;
      this.#centre.y = fixed.y + (this.#centre.y - fixed.y) * share;
    }
    this.#show();
  }

  /** Converts a point of the window to units of the drawing. @param {{ x: number, y: number } | undefined} at */
  #point(at) {
    const matrix = this.#svg?.getScreenCTM();
    return at && matrix ? new DOMPoint(at.x, at.y).matrixTransform(matrix.inverse()) : null;
  }

  #show() {
    const svg = this.#svg;
    const { width, height } = svg?.getBoundingClientRect() ?? new DOMRect();
    if (!svg || width === 0 || height === 0) return;
    const whole = this.#whole;
    let box = whole;
    if (this.#zoom > 1) {
      const scale = this.#zoom * Math.min(width / whole.width, height / whole.height);
      const [wide, high] = [width / scale, height / scale];
      const { x, y } = this.#centre;
      this.#centre.x = clampMiddle(x, wide, whole.x, whole.width);
      this.#centre.y = clampMiddle(y, high, whole.y, whole.height);
      box = new DOMRect(this.#centre.x - wide / 2, this.#centre.y - high / 2, wide, high);
    }
    setAttributes(svg, { viewBox: `${box.x} ${box.y} ${box.width} ${box.height}` });
    this.#map.classList.toggle("zoomed", this.#zoom > 1);
    this.#buttons.in.disabled = this.#zoom >= this.#maxZoom;
    this.#buttons.out.disabled = this.#buttons.reset.disabled = this.#zoom === 1;
    const matrix = svg.getScreenCTM();
    if (!matrix) return;
    svg.classList.toggle("small-cells", PITCH * matrix.a < MIN_CELL);
    this.#setWallWidths(svg, matrix.a);
    this.#showAxes(svg, matrix);
  }

  /** Keeps walls wide enough to be seen. @param {SVGSVGElement} svg @param {number} scale in pixels per unit */
  #setWallWidths(svg, scale) {
    for (const [kind, [min, minPixels, max]] of Object.entries(this.#wallWidths)) {
      svg.style.setProperty(`--${kind}-wall`, `${clamp(minPixels / scale, min, max).toFixed(2)}`);
    }
  }

  /** Writes the coordinates of the visible columns below the maze and those of the rows to the left of it. */
  /** @param {SVGSVGElement} svg @param {DOMMatrix} matrix from units to pixels */
  #showAxes(svg, { a: scale, e, f }) {
    const frame = svg.getBoundingClientRect();
    const map = this.#map.getBoundingClientRect();
    const { width, height } = this.#size;
    const pitch = PITCH * scale;
    const every = [1, 2, 5, 10].find((step) => step * pitch >= LABEL_DISTANCE) ?? 20;
    const left = Math.max(e - scale, frame.left) - map.left;
    const bottom = Math.min(f + (height * PITCH + 1) * scale, frame.bottom) - map.top;
    /** @type {HTMLElement[]} */
    const labels = [];
    /** @param {string} axis @param {number} i @param {number} x @param {number} y */
    const add = (axis, i, x, y) => {
      const label = Object.assign(document.createElement("span"), { className: axis, textContent: i });
      label.style.translate = `${x.toFixed(1)}px ${y.toFixed(1)}px`;
      labels.push(label);
    };
    for (let i = 0; i < width; i += every) {
      const x = e + (i + 0.5) * pitch;
      if (x > frame.left && x < frame.right) add("x", i, x - map.left, bottom);
    }
    for (let i = 0; i < height; i += every) {
      const y = f + (height - i - 0.5) * pitch;
      if (y > frame.top && y < frame.bottom) add("y", i, left, y - map.top);
    }
    this.#axes.replaceChildren(...labels);
  }

  /** Zooms, unless the wheel scrolls the page. With Ctrl, which a touchpad reports for a pinch, it always zooms. */
  /** @param {WheelEvent} event */
  #handleWheel(event) {
    const { ctrlKey, deltaY, deltaMode, clientX: x, clientY: y } = event;
    if (!ctrlKey && isInScrollable(this.#map)) return;
    event.preventDefault();
    const pixels = deltaMode === WheelEvent.DOM_DELTA_PIXEL ? deltaY : deltaY * 30;
    this.#zoomBy(WHEEL_FACTOR ** clamp(ctrlKey ? -5 * pixels : -pixels, -400, 400), { x, y });
  }

  /** @param {PointerEvent} event */
  #press({ pointerId, clientX: x, clientY: y, button }) {
    if (button === 0) this.#pointers.set(pointerId, { x, y });
  }

  /** @param {PointerEvent} event */
  #move(event) {
    const { pointerId, clientX: x, clientY: y } = event;
    // The button may have been released outside the map.
    if (!event.buttons) this.#release(event);
    const before = this.#pointers.get(pointerId);
    if (!before) return;
    const moved = Math.hypot(x - before.x, y - before.y);
    const pinch = this.#pointers.size > 1;
    if (!this.#dragging && (moved < DRAG_THRESHOLD || (this.#zoom === 1 && !pinch))) return;
    this.#dragging = true;
    this.#map.setPointerCapture(pointerId);
    const [from, to] = [this.#grip(), this.#pointers.set(pointerId, { x, y }) && this.#grip()];
    const [start, end] = [this.#point(from), this.#point(to)];
    if (start && end) {
      this.#centre.x += start.x - end.x;
      this.#centre.y += start.y - end.y;
    }
    if (pinch && from.spread > 0) this.#zoomBy(to.spread / from.spread, to);
    else this.#show();
  }

  /** Returns the middle of the pressed pointers and the distance between them. */
  #grip() {
    const [one, other = one] = [...this.#pointers.values()];
    return { x: (one.x + other.x) / 2, y: (one.y + other.y) / 2, spread: Math.hypot(one.x - other.x, one.y - other.y) };
  }

  /** @param {PointerEvent} event */
  #release({ pointerId }) {
    this.#pointers.delete(pointerId);
    if (this.#pointers.size === 0) this.#dragging = false;
  }
}

/** @param {number} value @param {number} min @param {number} max */
const clamp = (value, min, max) => Math.max(min, Math.min(value, max));

/** Returns the middle of a visible range of this length, so that the range shows as much of the whole as possible. */
/** @param {number} middle @param {number} length @param {number} start @param {number} whole */
function clampMiddle(middle, length, start, whole) {
  if (length >= whole) return start + whole / 2;
  return clamp(middle, start + length / 2, start + whole - length / 2);
}

/** True if a part of the page that contains the element can scroll vertically. @param {Element} element */
function isInScrollable(element) {
  for (let box = element.parentElement; box; box = box.parentElement) {
    const isRoot = box === document.documentElement;
    if (box.scrollHeight > box.clientHeight + 1 && (isRoot || /auto|scroll/.test(getComputedStyle(box).overflowY))) return true;
  }
  return false;
}
