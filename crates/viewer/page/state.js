// @ts-check
// Decodes states, which are messages `S` as described in docs/protocol.md.

/**
 * A decoded state. `weights` and `walls` store the cell (x, y) at index y * width + x. Headings are
 * numbered clockwise, starting with north = 0.
 * @typedef {{ x: number, y: number, heading: number, weights: Uint8Array, walls: Uint8Array }} State
 * @typedef {{ width: number, height: number }} Size
 */

/** The weight of a cell without a path to the goal. */
export const NO_PATH = 255;
export const VISITED = 1;
/** The bit of a cell's wall for each heading. */
const [NORTH, EAST, SOUTH, WEST] = [16, 2, 4, 8];
export const HEADINGS = ["north", "east", "south", "west"];
/** The offset to the next cell for each heading. */
export const DX = [0, 1, 0, -1];
export const DY = [1, 0, -1, 0];
/** The width of a cell in units of the drawing. */
export const PITCH = 20;

/** Returns the centre of a cell in units of the drawing. @param {number} x @param {number} y @param {Size} size */
export const centre = (x, y, { height }) => `${(x + 0.5) * PITCH} ${(height - y - 0.5) * PITCH}`;

/** Returns the north-western corner of a cell in units of the drawing. @param {number} cell @param {Size} size @returns {[number, number]} */
export const corner = (cell, { width, height }) => [(cell % width) * PITCH, (height - 1 - Math.floor(cell / width)) * PITCH];

/**
 * Returns 1 for each wall that the mouse reports, by 2 * its cell + (1 if it is an east wall, 0 if it is a north wall). The
 * walls around the maze count as reported.
 * @param {Uint8Array} walls @param {[number, boolean][]} declared inner walls that override the flags @param {Size} size
 */
export function reportedWalls(walls, declared, { width, height }) {
  const reported = new Uint8Array(2 * width * height).fill(1);
  for (let cell = 0; cell < width * height; cell++) {
    const [north, east] = [cell + width, cell + 1];
    if (north < width * height) reported[2 * cell] = walls[cell] & NORTH || walls[north] & SOUTH ? 1 : 0;
    if (east % width > 0) reported[2 * cell + 1] = walls[cell] & EAST || walls[east] & WEST ? 1 : 0;
  }
  for (const [wall, isPresent] of declared) reported[wall] = Number(isPresent);
  return reported;
}

const COLUMN_MAJOR = "F".charCodeAt(0);

/** @param {Uint8Array} message @param {Size} size @returns {State} */
export function decodeState(message, size) {
  const cells = size.width * size.height;
  return {
    x: message[1],
    y: message[2],
    heading: "NESW".indexOf(String.fromCharCode(message[3])),
    weights: decodeMatrix(message.subarray(4, 5 + cells), size),
    walls: decodeMatrix(message.subarray(5 + cells), size),
  };
}

/** @param {Uint8Array} encoded the order of the cells, then one byte per cell @param {Size} size */
function decodeMatrix(encoded, { width, height }) {
  const bytes = encoded.subarray(1);
  if (encoded[0] !== COLUMN_MAJOR) return bytes;
  const rows = new Uint8Array(bytes.length);
  for (let x = 0; x < width; x++) {
    for (let y = 0; y < height; y++) rows[y * width + x] = bytes[x * height + y];
  }
  return rows;
}
