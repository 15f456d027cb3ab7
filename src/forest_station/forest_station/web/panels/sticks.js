// Two sticks and the deadman, for fingers and the mouse; they show what keys and gamepads do, too.

import { make } from "../elements.js";
import { handsOf } from "../hands/hands.js";
import { makeHoldButton } from "../hands/hold_button.js";
import { AXES, LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y } from "../hands/joy.js";
import { makeStick } from "../hands/stick.js";

export const place = "bottom";
export const title = "";

const BUTTON = "the button";

export function mount(element, station) {
  const hands = handsOf(station);
  const left = stick(hands, "left", LEFT_X, LEFT_Y, ["away", "W"], ["back", "S"], ["left", "A"], ["right", "D"]);
  const right = stick(hands, "right", RIGHT_X, RIGHT_Y, ["up", "↑"], ["down", "↓"]);
  const deadman = makeHoldButton("HOLD TO DRIVE", (pressed) => hands.hold(BUTTON, pressed));
  deadman.append(make("small", {}, "deadman: this button, ", make("kbd", {}, "left Shift"), ", or a gamepad's left shoulder"));
  element.append(left.pad, deadman, right.pad);
  let counts = false; // for the server, which judges
  const show = () => {
    left.show(hands.axes[LEFT_X], hands.axes[LEFT_Y]);
    right.show(hands.axes[RIGHT_X], hands.axes[RIGHT_Y]);
    const { held } = hands.deadman;
    deadman.dataset.state = held ? (counts ? "held" : "pressed") : "released";
    deadman.setAttribute("aria-pressed", held);
  };
  hands.addEventListener("change", show);
  station.on("seat", (seat) => {
    counts = seat.you_drive && seat.deadman.state !== "waiting";
    show();
  });
}

// A stick on two axes; the words at its edges say what each way does, and its key.
function stick(hands, name, x, y, ...ways) {
  const made = makeStick(`${name} stick: tip ${ways.map(([word]) => word).join(", ")}`, (toLeft, up) => {
    const axes = AXES.map(() => 0);
    axes[x] = toLeft;
    axes[y] = up;
    hands.moveStick(name, axes);
  });
  made.pad.id = `${name}_stick`;
  for (const [word, key] of ways) {
    made.pad.append(make("span", { className: `way ${word}` }, word, make("kbd", {}, key)));
  }
  return made;
}
