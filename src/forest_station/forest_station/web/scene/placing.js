// Where texts over the picture go, so that none covers another one; pure. Places and sizes are in pixels of the page.

const EDGE = 24; // that a label's middle keeps from top and bottom
const [LETTER, ENDS, HIGH] = [4.5, 12, 28]; // half a letter, half of what is around them, a line: nobody measures a label
const LIFT = { limit: -36, calm: -36, taught: 22 }; // of labels that stand beside what they name
const FIRST = ["limit", "load", "goal", "calm", "figure", "taught", "rigid"]; // the most important keep their places
const TRIES = [0, -1, 1, -2, 2, -3, 3, -4, 4, -5, 5]; // lines up or down, until there is room
const LOST = "rigid"; // says nothing where it does not belong

// Returns labels {key, text, kind, x, y} with the places that they get; one for which there is no room is left out.
//
// taken: [left, top, right, bottom] of what lies over the picture already.
export function placed(labels, { width, height }, taken = []) {
  const boxes = [...taken];
  const inside = ({ x, y }) => x >= 0 && y >= 0 && x <= width && y <= height;
  const sorted = [...labels].sort((a, b) => FIRST.indexOf(a.kind) - FIRST.indexOf(b.kind));
  return sorted.flatMap((label) => {
    if (label.kind === LOST && !inside(label)) return [];
    const half = LETTER * label.text.length + ENDS;
    const x = Math.min(width - half, Math.max(half, label.x));
    const keep = (y) => Math.min(height - EDGE, Math.max(EDGE, y));
    const box = (y) => [x - half, y - HIGH / 2, x + half, y + HIGH / 2];
    const wanted = keep(label.y + (LIFT[label.kind] ?? 0));
    const y = TRIES.map((lines) => wanted + lines * HIGH).find((at) => at === keep(at) && !boxes.some((other) => overlap(box(at), other)));
    if (y === undefined) return [];
    boxes.push(box(y));
    return [{ ...label, x, y }];
  });
}

function overlap([left, top, right, bottom], [l, t, r, b]) {
  return left < r && l < right && top < b && t < bottom;
}
