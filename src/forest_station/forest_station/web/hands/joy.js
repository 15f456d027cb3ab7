// Axes and buttons as /joy carries them, in the order of ROS's game_controller_node, and how several sources become one.
// What they mean: docs/reference/topics.md and forest_control's operator/levers.py (left and up are positive).

export const AXES = ["left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger"];
export const BUTTONS = [
  "a", "b", "x", "y", "back", "guide", "start", "left_stick", "right_stick", "left_shoulder", "right_shoulder",
  "dpad_up", "dpad_down", "dpad_left", "dpad_right", "misc", "paddle_1", "paddle_2", "paddle_3", "paddle_4", "touchpad",
];
export const [LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y] = [0, 1, 2, 3];
export const DEADMAN = BUTTONS.indexOf("left_shoulder");
export const CENTRED = Object.freeze(AXES.map(() => 0));

export const clamp = (value) => (Number.isFinite(value) ? Math.min(1, Math.max(-1, value)) : 0);

// One value per axis: of several hands on the same axis the one that asks for most.
export function mergeAxes(sources) {
  return AXES.map((_, axis) =>
    sources.reduce((most, axes) => (Math.abs(clamp(axes[axis])) > Math.abs(most) ? clamp(axes[axis]) : most), 0),
  );
}

// A deflection without the small ones that nobody means, and without a step behind them.
export function withDeadzone(value, deadzone) {
  const size = Math.abs(value);
  return size <= deadzone ? 0 : (Math.sign(value) * (size - deadzone)) / (1 - deadzone);
}

// The buttons' bits. The deadman's button says what the deadman says, whatever is pressed.
export function buttonBits(pressed, held) {
  const bits = pressed.reduce((sum, down, button) => (down ? sum | (1 << button) : sum), 0);
  return (held ? bits | (1 << DEADMAN) : bits & ~(1 << DEADMAN)) >>> 0;
}
