// The keyboard as two sticks. Keys are named by their place, as on a US keyboard, so that the sticks keep their shape.

import { AXES, LEFT_X, LEFT_Y, RIGHT_Y } from "./joy.js";

export const KEYS = {
  KeyW: { axis: LEFT_Y, sign: 1, label: "W", does: "tip away" },
  KeyS: { axis: LEFT_Y, sign: -1, label: "S", does: "tip back" },
  KeyA: { axis: LEFT_X, sign: 1, label: "A", does: "tip left" },
  KeyD: { axis: LEFT_X, sign: -1, label: "D", does: "tip right" },
  ArrowUp: { axis: RIGHT_Y, sign: 1, label: "↑", does: "tip up" },
  ArrowDown: { axis: RIGHT_Y, sign: -1, label: "↓", does: "tip down" },
};

// A modifier: every keyboard reports it beside any other keys, and each event tells whether it is still down.
export const DEADMAN_KEY = "ShiftLeft";
export const OTHER_SHIFT = "ShiftRight";
export const STOP_KEYS = ["Escape", "Space"];

const PRESS_PER_S = 2.5; // a full deflection in 0.4 s
const RELEASE_PER_S = 8; // and back in 0.125 s

// The deflections that pressed keys ask for.
export function wantedAxes(pressed) {
  const axes = AXES.map(() => 0);
  for (const code of pressed) if (KEYS[code]) axes[KEYS[code].axis] += KEYS[code].sign;
  return axes;
}

// The deflections `dt` seconds later: slowly outwards, fast back, and through the centre.
export function rampedAxes(axes, wanted, dt) {
  return axes.map((value, axis) => ramped(value, wanted[axis], dt));
}

function ramped(value, wanted, dt) {
  const inwards = value !== 0 && value * wanted < value * value;
  const target = inwards && value * wanted < 0 ? 0 : wanted;
  const step = (inwards ? RELEASE_PER_S : PRESS_PER_S) * dt;
  return value < target ? Math.min(target, value + step) : Math.max(target, value - step);
}
