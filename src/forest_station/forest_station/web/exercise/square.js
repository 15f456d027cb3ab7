// A square for the tip to be driven along, and how well it was; pure. Points are [x, y, z] in the base frame [m].

export const SIDE = 0.8; // [m]
export const REACHED = 0.1; // [m] around a corner
const STEP = 0.01; // [m] of way between two looks at how far beside the tip is: who stands still is not measured twice
const FAR = 6; // [m] from the swing axis, amid the reach: from there the square lies towards the crane, else away from it

// Returns a level square that begins at the tip, its sides along the tip's own directions.
export function squareAt([x, y, z]) {
  const along = Math.hypot(x, y) > FAR ? -SIDE : SIDE;
  return [[x, y, z], [x + along, y, z], [x + along, y + SIDE, z], [x, y + SIDE, z]];
}

export function begun(corners) {
  return { corners, side: 0, seen: corners[0], sum: 0, way: 0, most: 0, since: null, until: null };
}

// Returns the attempt after the tip was seen at a place and a time [s]. Time counts from the first motion on. A corner is
// reached near it, or beside it: who goes too far is off the square, but not lost.
export function after(attempt, tip, time) {
  if (isDone(attempt) || !tip.every(Number.isFinite)) return attempt;
  const [from, to] = side(attempt);
  const step = distance(tip, attempt.seen);
  if (step < STEP) return attempt;
  const off = distanceToSegment(tip, from, to);
  const next = {
    ...attempt,
    seen: tip,
    since: attempt.since ?? time,
    sum: attempt.sum + off * off * step,
    way: attempt.way + step,
    most: Math.max(attempt.most, off),
  };
  if (distance(tip, to) > REACHED && wayLeft(tip, from, to) > 0) return next;
  const last = attempt.side === attempt.corners.length - 1;
  return { ...next, side: attempt.side + 1, until: last ? time : null };
}

export function isDone(attempt) {
  return attempt.side >= attempt.corners.length;
}

// The corners between which the tip is to be.
export function side({ corners, side: number }) {
  return [corners[number % corners.length], corners[(number + 1) % corners.length]];
}

// How far from the square the tip was: root mean square over its way and most [m], and for how long [s].
export function result({ sum, way, most, since, until }) {
  return { rms: Math.sqrt(sum / way), most, seconds: until - since };
}

// What the left stick has to do next, from where the tip is: its word, its key, and how far [m].
export function way(attempt, tip) {
  const [, to] = side(attempt);
  const [x, y] = [to[0] - tip[0], to[1] - tip[1]];
  if (Math.abs(x) > Math.abs(y)) return x > 0 ? ["away", "W", x] : ["back", "S", -x];
  return y > 0 ? ["left", "A", y] : ["right", "D", -y];
}

// How far the corner is along the side [m]; negative: the tip has passed it.
function wayLeft(tip, from, to) {
  const along = from.map((start, i) => to[i] - start);
  return dot(to.map((end, i) => end - tip[i]), along) / Math.hypot(...along);
}

function distanceToSegment(point, from, to) {
  const along = from.map((start, i) => to[i] - start);
  const way = from.map((start, i) => point[i] - start);
  const share = dot(way, along) / dot(along, along);
  const foot = from.map((start, i) => start + Math.min(1, Math.max(0, share)) * along[i]);
  return distance(point, foot);
}

function distance(a, b) {
  return Math.hypot(...a.map((value, i) => value - b[i]));
}

function dot(a, b) {
  return a.reduce((sum, value, i) => sum + value * b[i], 0);
}
