// What the axes and buttons of a gamepad or a joystick mean: a mapping, as it is edited, calibrated, saved and exchanged.
//
// A mapping has `axes`: for each axis of /joy {from, invert, deadzone, low, centre, high} or null, and `buttons`: for each
// button of /joy a number of the device, or null. `from` is "axis N" or "button N" of the device.

import { AXES, BUTTONS, LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y, clamp, withDeadzone } from "./joy.js";

const DEADZONE = 0.08;
const SMALLEST_SPAN = 0.2; // of a calibrated half axis: less is noise

// The browser's standard gamepad, button by button of /joy; what it does not know is null.
const STANDARD_BUTTONS = [0, 1, 2, 3, 8, 16, 9, 10, 11, 4, 5, 12, 13, 14, 15, 17, null, null, null, null, null];

const entry = (from, invert = false) => ({ from, invert, deadzone: DEADZONE, low: -1, centre: 0, high: 1 });

// The browser counts right and down as positive, /joy left and up.
export function standardMapping() {
  const sticks = [0, 1, 2, 3].map((axis) => entry(`axis ${axis}`, true));
  return { axes: [...sticks, entry("button 6"), entry("button 7")], buttons: [...STANDARD_BUTTONS] };
}

// Any other device is one stick, left or right; its deadman is nobody's guess.
export function joystickMapping(right) {
  const axes = AXES.map(() => null);
  axes[right ? RIGHT_X : LEFT_X] = entry("axis 0", true);
  axes[right ? RIGHT_Y : LEFT_Y] = entry("axis 1", true);
  return { axes, buttons: BUTTONS.map(() => null) };
}

export const newEntry = entry;

// What the device's part `from` says, untreated.
export function rawValue(device, from) {
  const [kind, number] = from.split(" ");
  return (kind === "axis" ? device.axes[number] : device.buttons[number]?.value) ?? NaN;
}

export function mappedAxes(device, mapping) {
  return mapping.axes.map((one) => (one ? deflection(rawValue(device, one.from), one) : 0));
}

export function mappedButtons(device, mapping) {
  return mapping.buttons.map((number) => Boolean(number !== null && device.buttons[number]?.pressed));
}

function deflection(raw, { invert, deadzone, low, centre, high }) {
  const scaled = raw >= centre ? (raw - centre) / (high - centre || 1) : (raw - centre) / (centre - low || 1);
  return withDeadzone(clamp(scaled), deadzone) * (invert ? -1 : 1) || 0;
}

// The ends that an axis showed while it was moved; an axis that did not move keeps what it had.
export function calibrated(one, { centre, low, high }) {
  const moved = Math.max(high - centre, centre - low) >= SMALLEST_SPAN;
  if (!moved) return one;
  const oneSided = (span) => span < SMALLEST_SPAN; // as a trigger or a throttle
  return {
    ...one,
    centre,
    low: oneSided(centre - low) ? centre - 1 : low,
    high: oneSided(high - centre) ? centre + 1 : high,
  };
}

// Reads a mapping from JSON's values; throws one sentence that says what is wrong.
export function checkedMapping(value) {
  const { axes, buttons } = value ?? {};
  if (!Array.isArray(axes) || axes.length !== AXES.length) throw new Error(`A mapping has ${AXES.length} axes.`);
  if (!Array.isArray(buttons) || buttons.length !== BUTTONS.length) {
    throw new Error(`A mapping has ${BUTTONS.length} buttons.`);
  }
  return { axes: axes.map(checkedEntry), buttons: buttons.map(checkedButton) };
}

function checkedEntry(one, axis) {
  if (one === null) return null;
  const { from, invert, deadzone, low, centre, high } = one ?? {};
  if (!/^(axis|button) \d{1,2}$/.test(from)) throw new Error(`${AXES[axis]}: "from" is "axis N" or "button N".`);
  if (typeof invert !== "boolean") throw new Error(`${AXES[axis]}: "invert" is true or false.`);
  if (!(deadzone >= 0 && deadzone <= 0.5)) throw new Error(`${AXES[axis]}: "deadzone" is from 0 to 0.5.`);
  if (!(low < centre && centre < high && Number.isFinite(high - low))) {
    throw new Error(`${AXES[axis]}: "low", "centre" and "high" are numbers that rise.`);
  }
  return { from, invert, deadzone, low, centre, high };
}

function checkedButton(number, button) {
  if (number === null || (Number.isInteger(number) && number >= 0 && number < 64)) return number;
  throw new Error(`${BUTTONS[button]}: a button's number is from 0 to 63, or null.`);
}
