// The exercise in words: what to do next, and how well it went; pure.

const BESIDE = 0.15; // [m] from which on the tip is to be brought back
const LITTLE = 0.3; // [m] of that, up to which it is called little

// What to do next, of `way` in square.js; `fingers`: of a person who has no keys.
export function wayText({ word, key, metres, beside, wrong }, fingers) {
  const push = fingers ? `push the left stick ${word}` : `push the left stick ${word}, or press ${key}`;
  const begin = wrong ? "this is the wrong way: " : "";
  const little = beside.metres < LITTLE ? "a little " : "";
  const aside = beside.metres >= BESIDE ? `, and ${little}${beside.word}: ${beside.metres.toFixed(1)} m` : "";
  return `${begin}${push}: ${metres.toFixed(1)} m to go${aside}.`;
}

// How well it went, of `result` in square.js; `best`: the least mean distance of the attempts before [m], NaN for none.
export function resultText({ mean, most, seconds }, best) {
  const before = Number.isFinite(best) ? ` Your best before: ${cm(best)}.` : "";
  return `Done, in ${seconds.toFixed(0)} s of motion: the tip was ${cm(mean)} from the edge on average, ${cm(most)} at most.${before}`;
}

function cm(metres) {
  return `${(100 * metres).toFixed(1)} cm`;
}
