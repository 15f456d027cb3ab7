// A square for the tip to be driven along, and how well it was; pure. Points are [x, y, z] in the base frame [m].

export const SIDE = 0.8; // [m]
export const REACHED = 0.1; // [m] around a corner
const STEP = 0.01; // [m] of way between two looks at how far beside the tip is: who stands still is not measured twice
const PAUSE_S = 0.5; // longest time for a step that counts as motion
const [ASTRAY, BACK] = [0.1, 0.05]; // [m] from the corner, after which the way is wrong; towards it, and it is right again
const FAR = 6; // [m] from the swing axis, amid the reach: from there the square lies towards the crane, else away from it

// Returns a level square that begins at the tip, its sides along the tip's own directions.
export function squareAt([x, y, z]) {
  const along = Math.hypot(x, y) > FAR ? -SIDE : SIDE;
  return [[x, y, z], [x + along, y, z], [x + along, y + SIDE, z], [x, y + SIDE, z]];
}

export function begun(corners) {
  const onSide = { side: 0, mark: Infinity, wrong: false };
  return { corners, ...onSide, seen: corners[0], at: NaN, sum: 0, way: 0, most: 0, seconds: 0 };
}

// Returns the attempt after the tip was seen at a place and a time [s]. Only motion counts, way and time. A corner is
// reached near it, or beside it: who goes too far is off the square, but not lost.
export function after(attempt, tip, time) {
  if (isDone(attempt) || !tip.every(Number.isFinite)) return attempt;
  const [from, to] = side(attempt);
  const step = distance(tip, attempt.seen);
  if (step < STEP) return attempt;
  const off = distanceToSegment(tip, from, to);
  const next = {
    ...attempt,
    ...turned(attempt, wayLeft(tip, from, to)),
    seen: tip,
    at: time,
    seconds: attempt.seconds + Math.min(PAUSE_S, time - attempt.at || 0),
    sum: attempt.sum + off * step,
    way: attempt.way + step,
    most: Math.max(attempt.most, off),
  };
  if (distance(tip, to) > REACHED && wayLeft(tip, from, to) > 0) return next;
  return { ...next, side: attempt.side + 1, mark: Infinity, wrong: false };
}

// Whether the tip goes away from the corner, `left` [m] of the side before it. The mark is the nearest so far on the right
// way, the farthest on the wrong one.
function turned({ mark, wrong }, left) {
  if (wrong) return left < mark - BACK ? { wrong: false, mark: left } : { wrong, mark: Math.max(mark, left) };
  return left > mark + ASTRAY ? { wrong: true, mark: left } : { wrong, mark: Math.min(mark, left) };
}

export function isDone(attempt) {
  return attempt.side >= attempt.corners.length;
}

// The corners between which the tip is to be.
export function side({ corners, side: number }) {
  return [corners[number % corners.length], corners[(number + 1) % corners.length]];
}

// How far from the edge to be driven the tip was: mean over its way, and most [m]; and for how long it moved [s].
export function result({ sum, way, most, seconds }) {
  return { mean: sum / way, most, seconds };
}

// What the left stick has to do next: {word, key, metres} along the side, {word, metres} back to the side, and whether the
// tip goes the wrong way.
export function way(attempt, tip) {
  const [from, to] = side(attempt);
  const [x, y] = [to[0] - tip[0], to[1] - tip[1]];
  const [along, across] = Math.abs(to[0] - from[0]) > Math.abs(to[1] - from[1]) ? [pushX(x), pushY(y)] : [pushY(y), pushX(x)];
  return { ...along, beside: across, wrong: attempt.wrong };
}

const pushX = (x) => ({ word: x > 0 ? "away" : "back", key: x > 0 ? "W" : "S", metres: Math.abs(x) });
const pushY = (y) => ({ word: y > 0 ? "left" : "right", key: y > 0 ? "A" : "D", metres: Math.abs(y) });

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
