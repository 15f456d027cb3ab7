// A square for the tip to be driven along, and how well it was; pure. Points are [x, y, z] in the base frame [m].

export const SIDE = 0.8; // [m]
export const REACHED = 0.1; // [m] around a corner
const OFF = SIDE / 2; // [m] beside and above a corner, from which on who passes it has not reached it
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

// Returns the attempt after the tip was seen at a place and a time [s]; `pushed`: a stick or a key was away from its centre.
// Only motion counts, way and time. A corner is reached near it, or by passing it not too far off: who goes too far along
// the side is off the square, but not lost.
export function after(attempt, tip, time, pushed = true) {
  if (isDone(attempt) || !tip.every(Number.isFinite)) return attempt;
  const [from, to] = side(attempt);
  const left = wayLeft(tip, from, to);
  const step = distance(tip, attempt.seen);
  if (step < STEP) return pushed ? attempt : { ...attempt, ...turned(attempt, left, pushed) };
  const off = distanceToSegment(tip, from, to);
  const next = {
    ...attempt,
    ...turned(attempt, left, pushed),
    seen: tip,
    at: time,
    seconds: attempt.seconds + Math.min(PAUSE_S, time - attempt.at || 0),
    sum: attempt.sum + off * step,
    way: attempt.way + step,
    most: Math.max(attempt.most, off),
  };
  const passed = left <= 0 && Math.sqrt(Math.max(0, distance(tip, to) ** 2 - left ** 2)) < OFF;
  if (distance(tip, to) > REACHED && !passed) return next;
  return { ...next, side: attempt.side + 1, mark: Infinity, wrong: false };
}

// Whether the tip is pushed away from the corner, `left` [m] of the side before it. The mark is the nearest so far on the
// right way, the farthest on the wrong one. Who lets go begins anew.
function turned({ mark, wrong }, left, pushed) {
  if (!pushed) return { wrong: false, mark: left };
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

// What the sticks have to do: {along, aside, height}, each with `stick`, `word` and `key` of a push, and the `metres` that
// it has to bring; whether the tip is pushed the wrong way; and the word for the side behind the corner, "" for the last.
export function way(attempt, tip) {
  const [from, to] = side(attempt);
  const isX = alongX(from, to);
  const along = isX ? pushX(to[0] - from[0]) : pushY(to[1] - from[1]);
  const aside = isX ? pushY(to[1] - tip[1]) : pushX(to[0] - tip[0]);
  const left = Math.max(0, wayLeft(tip, from, to));
  return { along: { ...along, metres: left }, aside, height: pushZ(to[2] - tip[2]), wrong: attempt.wrong, then: then(attempt) };
}

function then(attempt) {
  if (attempt.side + 1 >= attempt.corners.length) return "";
  const [from, to] = side({ ...attempt, side: attempt.side + 1 });
  return (alongX(from, to) ? pushX(to[0] - from[0]) : pushY(to[1] - from[1])).word;
}

const alongX = (from, to) => Math.abs(to[0] - from[0]) > Math.abs(to[1] - from[1]);
const push = (stick, [word, key], metres) => ({ stick, word, key, metres: Math.abs(metres) });
const pushX = (x) => push("left", x > 0 ? ["away", "W"] : ["back", "S"], x);
const pushY = (y) => push("left", y > 0 ? ["left", "A"] : ["right", "D"], y);
const pushZ = (z) => push("right", z > 0 ? ["up", "↑"] : ["down", "↓"], z);

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
