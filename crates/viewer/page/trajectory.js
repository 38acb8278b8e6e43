// @ts-check
// The state of a mouse at any time of a fast run. The jerk is constant within each piece of a straight, and turns are
// cubic spirals at constant speed, so the state at any time is exact.

/**
 * Lengths are in mm, times in s, and angles in radians, counterclockwise from east.
 * @typedef {import("./api.js").TimedRun} TimedRun
 * @typedef {TimedRun["segments"][0]} Segment
 * @typedef {{ x: number, y: number, heading: number, speed: number, acceleration: number }} Moment
 */

/** The nodes and weights of the Gauss–Legendre quadrature with five points. */
const NODES = [
  [0, 0.5688888888888889],
  [0.538469310105683, 0.47862867049936647],
  [-0.538469310105683, 0.47862867049936647],
  [0.906179845938664, 0.23692688505618908],
  [-0.906179845938664, 0.23692688505618908],
];
/** The number of parts of an arc that are integrated separately. */
const PARTS = 8;
/** The number of lines that draw a turn or a piece of a straight. */
const LINES = 24;

export class Trajectory {
  /** @param {TimedRun} run */
  constructor(run) {
    this.run = run;
  }

  /** Returns the state at a time. Times outside of the run count as its beginning or end. @param {number} time @returns {Moment} */
  at(time) {
    const segment = this.segmentAt(time);
    if (!segment) return { x: this.run.x_mm, y: this.run.y_mm, heading: Math.PI / 2, speed: 0, acceleration: 0 };
    const within = Math.min(Math.max(0, time - segment.start_s), segment.duration_s);
    const moment = segment.turn === null ? onStraight(segment, within) : onArc(segment, within);
    return time < this.run.time_s ? moment : { ...moment, speed: segment.exit_speed_mm_s, acceleration: 0 };
  }

  /** Returns the segment at a time, or null if the run is empty. @param {number} time @returns {Segment | null} */
  segmentAt(time) {
    const { segments } = this.run;
    return segments.findLast((segment) => segment.start_s <= time) ?? segments[0] ?? null;
  }

  /** Returns the states at which lines that draw the run begin and end. @returns {Moment[]} */
  outline() {
    const steps = this.run.segments.flatMap((segment) =>
      Array.from({ length: LINES }, (_, i) => segment.start_s + (segment.duration_s * i) / LINES),
    );
    return [...steps, this.run.time_s].map((time) => this.at(time));
  }

  /** Returns the times, speeds and accelerations between which they change linearly, or nearly so. */
  profile() {
    /** @type {[time: number, speed: number, acceleration: number][]} */
    const points = [];
    for (const { turn, start_s: time, duration_s, entry_speed_mm_s: speed, pieces } of this.run.segments) {
      let began = time;
      if (turn !== null) points.push([time, speed, 0], [time + duration_s, speed, 0]);
      for (const piece of pieces) {
        const count = piece[3] === 0 ? 1 : LINES;
        for (let i = 0; i <= count; i++) {
          const within = (piece[0] * i) / count;
          const { now, acceleration } = inPiece(piece, within);
          points.push([began + within, now, acceleration]);
        }
        began += piece[0];
      }
    }
    return points;
  }
}

/** @param {Segment["pieces"][0]} piece @param {number} time since the beginning of the piece */
function inPiece([, speed, acceleration, jerk], time) {
  return {
    distance: time * (speed + time * (acceleration / 2 + (time * jerk) / 6)),
    now: speed + time * (acceleration + (time * jerk) / 2),
    acceleration: acceleration + time * jerk,
  };
}

/** @param {Segment} segment @param {number} time since the beginning of the segment @returns {Moment} */
function onStraight({ x_mm: x, y_mm: y, heading_rad: heading, entry_speed_mm_s: speed, pieces }, time) {
  let [covered, now, change, rest] = [0, speed, 0, time];
  for (const piece of pieces) {
    const { distance, now: speed, acceleration } = inPiece(piece, Math.min(rest, piece[0]));
    [covered, now, change] = [covered + distance, speed, acceleration];
    rest -= piece[0];
    if (rest <= 0) break;
  }
  return { x: x + covered * Math.cos(heading), y: y + covered * Math.sin(heading), heading, speed: now, acceleration: change };
}

/** @param {Segment} segment @param {number} time since the beginning of the segment @returns {Moment} */
function onArc({ x_mm: x, y_mm: y, heading_rad: heading, entry_speed_mm_s: speed, length_mm: length, angle_rad: angle }, time) {
  const q = (time * speed) / length;
  const { forward, aside } = displacement(angle, q);
  const [sin, cos] = [Math.sin(heading), Math.cos(heading)];
  return {
    x: x + length * (forward * cos - aside * sin),
    y: y + length * (forward * sin + aside * cos),
    heading: heading + angle * turned(q),
    speed,
    acceleration: 0,
  };
}

/** Returns the heading after the fraction `q` of an arc, as a fraction of the whole turn. @param {number} q */
const turned = (q) => q * q * (3 - 2 * q);

/**
 * Returns the displacement after the fraction `q` of an arc, forward and to the left, as fractions of its length.
 * @param {number} angle @param {number} q
 */
function displacement(angle, q) {
  const half = q / (2 * PARTS);
  let [forward, aside] = [0, 0];
  for (let part = 0; part < PARTS; part++) {
    for (const [node, weight] of NODES) {
      const heading = angle * turned(half * (2 * part + 1 + node));
      forward += half * weight * Math.cos(heading);
      aside += half * weight * Math.sin(heading);
    }
  }
  return { forward, aside };
}
