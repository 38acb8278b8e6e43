// @ts-check
// What a state says: the bytes of the message `S`, see docs/protocol.md.

/**
 * Matrices have the cell (x, y) at y * width + x, in whichever order they were sent. Headings count
 * clockwise: north is 0.
 * @typedef {{ x: number, y: number, heading: number, weights: Uint8Array, walls: Uint8Array }} State
 */

export const VISITED = 1;
/** The bit of a cell's wall by heading: north, east, south, west. */
export const WALL_BITS = [16, 2, 4, 8];
export const HEADINGS = ["north", "east", "south", "west"];

const COLUMN_BY_COLUMN = "F".charCodeAt(0);

/**
 * @param {Uint8Array} message
 * @param {{ width: number, height: number }} size
 * @returns {State}
 */
export function readState(message, size) {
    const cells = size.width * size.height;
    return {
        x: message[1],
        y: message[2],
        heading: "NESW".indexOf(String.fromCharCode(message[3])),
        weights: readMatrix(message.subarray(4, 5 + cells), size),
        walls: readMatrix(message.subarray(5 + cells), size),
    };
}

/** @param {Uint8Array} sent the order, then a byte a cell @param {{ width: number, height: number }} size */
function readMatrix(sent, { width, height }) {
    const bytes = sent.subarray(1);
    if (sent[0] !== COLUMN_BY_COLUMN) return bytes;
    const rows = new Uint8Array(bytes.length);
    for (let x = 0; x < width; x++) {
        for (let y = 0; y < height; y++) rows[y * width + x] = bytes[x * height + y];
    }
    return rows;
}
