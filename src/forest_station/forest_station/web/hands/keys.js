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

// No modifier: with Ctrl, Alt or Meta a browser takes W, A, S and D for its own, and Shift is the deadman.
export const [SLOWER_KEY, FASTER_KEY] = ["KeyQ", "KeyE"];
export const SPEEDS = [0.25, 0.5, 1]; // deflections that a pressed key asks for

// The speed after a key, from `SPEEDS`.
export function nextSpeed(speed, code) {
  const place = SPEEDS.indexOf(speed) + (code === FASTER_KEY ? 1 : -1);
  return SPEEDS[Math.min(SPEEDS.length - 1, Math.max(0, place))];
}

// A modifier: every keyboard reports it beside any other keys, and each event tells whether it is still down.
export const DEADMAN_KEY = "ShiftLeft";
export const OTHER_SHIFT = "ShiftRight";
export const STOP_KEYS = ["Escape", "Space"];

const PRESS_PER_S = 2.5; // a full deflection in 0.4 s
const RELEASE_PER_S = 8; // and back in 0.125 s

// The deflections that pressed keys ask for, at a speed.
export function wantedAxes(pressed, speed = 1) {
  const axes = AXES.map(() => 0);
  for (const code of pressed) if (KEYS[code]) axes[KEYS[code].axis] += speed * KEYS[code].sign;
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
