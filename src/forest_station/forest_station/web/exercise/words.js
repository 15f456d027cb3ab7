// The exercise in words: what to do next, and how well it went; pure.

import { isDone, result, way } from "./square.js";

const OFF = 0.15; // [m] beside, above or below the side, from which on the tip is to be brought back
const [TO_GO, BESIDE, HIGH, LOW] = ["to go", "beside the edge", "too high", "too low"];

// The panel's sentence.
//
// attempt: or null; tip: [x, y, z] [m]; best: least mean distance of the attempts before [m], NaN for none; advice: of
// hands/why.js; stopped: the emergency stop is active; seat: or null; fingers: of a person who has no keys; movesTip: sticks
// move the tip along the sides of the square; replays: the page shows a bag.
export function exerciseText({ attempt, tip, best, advice, stopped, seat, fingers, movesTip, replays = false }) {
  if (replays) return "The square is driven with the live crane.";
  if (!seat) return "Without a connection nothing can be driven.";
  if (stopped) return `Stopped. ${advice.order || "Who drives can reset it."}`;
  if (!attempt) return introduction(fingers);
  if (isDone(attempt)) return resultText(result(attempt), best);
  if (!seat.you_drive) {
    return seat.driver === null ? "Nobody drives: take the seat, at the top." : "Somebody else drives: ask for control, at the top.";
  }
  const number = `Edge ${attempt.side + 1} of 4`;
  if (!movesTip) return `${number} waits. Set Scheme to "coordinated" and Sticks' axes to "cartesian", in Settings.`;
  if (!advice.moves) return `${number} waits. ${advice.order}`.trim();
  return `${number}: ${wayText(way(attempt, tip), fingers)}`;
}

function introduction(fingers) {
  const stop = fingers ? "The red button" : "The space bar";
  return `Mark a square at the crane's tip, and drive along it; no stop is needed at its corners. ${stop} stops everything.`;
}

// What to do next, of `way` in square.js: the largest error first, and the next one that counts behind it.
export function wayText({ along, aside, height, wrong, then }, fingers) {
  const errors = [
    { ...along, is: TO_GO, counts: along.metres > 0 },
    { ...aside, is: BESIDE, counts: aside.metres >= OFF },
    { ...height, is: height.word === "down" ? HIGH : LOW, counts: height.metres >= OFF },
  ].filter(({ counts }) => counts);
  const rank = ({ is, metres }) => (wrong && is === TO_GO ? Infinity : metres);
  const [first, next] = errors.sort((a, b) => rank(b) - rank(a));
  if (!first) return "";
  const begin = wrong ? "this is the wrong way: " : "";
  return `${begin}${pushText(first, fingers)}${next ? besideText(next, fingers) : cornerText(then)}.`;
}

function pushText({ stick, word, key, metres, is }, fingers) {
  return `push the ${stick} stick ${word}${fingers ? "" : `, or press ${key}`}: ${metres.toFixed(1)} m ${is}`;
}

function besideText({ stick, word, key, metres, is }, fingers) {
  return `, and ${word} (${stick} stick${fingers ? "" : `, ${key}`}): ${metres.toFixed(1)} m ${is}`;
}

const cornerText = (then) => then && `, then ${then} without a stop`;

// How well it went, of `result` in square.js; `best`: the least mean distance of the attempts before [m], NaN for none.
export function resultText({ mean, most, seconds }, best) {
  const before = Number.isFinite(best) ? ` Your best before: ${cm(best)}.` : "";
  return `Done, in ${seconds.toFixed(0)} s of motion: the tip was ${cm(mean)} from the edge on average, ${cm(most)} at most.${before}`;
}

function cm(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
