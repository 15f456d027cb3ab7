// What each way of the sticks moves, in the words of the chosen scheme: forest_control's operator/levers.py.

const TIP = { away: "away", back: "back", left: "left", right: "right", up: "up", down: "down" };
const AROUND = { ...TIP, away: "out", back: "in", left: "round left", right: "round right" };
const JOINT = {
  away: "stick out", back: "stick in", left: "swing left", right: "swing right", up: "boom up", down: "boom down",
};

// By way: a word or two. A scheme or frame that is not known yet moves the tip, along the carrier's directions.
export function moves(scheme, frame) {
  if (scheme === "joint") return JOINT;
  return frame === "cylindrical" ? AROUND : TIP;
}

// Whether the sticks move the tip along the carrier's directions.
export const movesTip = (scheme, frame) => moves(scheme, frame) === TIP;
