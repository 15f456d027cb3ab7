// Two sticks and the deadman, for fingers and the mouse; they show what keys and gamepads do, too.

import { make, setText } from "../elements.js";
import { handsOf } from "../hands/hands.js";
import { makeHoldButton } from "../hands/hold_button.js";
import { AXES, LEFT_X, LEFT_Y, RIGHT_X, RIGHT_Y } from "../hands/joy.js";
import { moves } from "../hands/moves.js";
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
  const speed = make("b");
  const keys = make("small", { className: "speed" }, "keys push a stick by ", speed, " · ", make("kbd", {}, "Q"), " less · ",
    make("kbd", {}, "E"), " more");
  element.append(left.pad, make("div", { className: "middle" }, deadman, keys), right.pad);
  let counts = false; // for the server, which judges
  const show = () => {
    left.show(hands.axes[LEFT_X], hands.axes[LEFT_Y]);
    right.show(hands.axes[RIGHT_X], hands.axes[RIGHT_Y]);
    setText(speed, `${100 * hands.keyboard.speed} %`);
    const { held } = hands.deadman;
    deadman.dataset.state = held ? (counts ? "held" : "pressed") : "released";
    deadman.setAttribute("aria-pressed", held);
  };
  station.on("parameters", ({ nodes: { controller = {} } }) => {
    const words = moves(controller.scheme?.value, controller.axis_frame?.value);
    for (const { name } of [left, right]) name(words);
  });
  hands.addEventListener("change", show);
  show();
  station.on("seat", (seat) => {
    counts = seat.you_drive && seat.deadman.state !== "waiting";
    show();
  });
}

// A stick on two axes; the words at its edges say what each way does, and its key. `name(words)` names them anew.
function stick(hands, side, x, y, ...ways) {
  const made = makeStick((toLeft, up) => {
    const axes = AXES.map(() => 0);
    axes[x] = toLeft;
    axes[y] = up;
    hands.moveStick(side, axes);
  });
  made.pad.id = `${side}_stick`;
  const texts = new Map();
  for (const [way, key] of ways) {
    texts.set(way, make("span"));
    made.pad.append(make("span", { className: `way ${way}` }, texts.get(way), make("kbd", {}, key)));
  }
  const name = (words) => {
    for (const [way, text] of texts) setText(text, words[way]);
    made.pad.setAttribute("aria-label", `${side} stick: ${[...texts.keys()].map((way) => words[way]).join(", ")}`);
  };
  name(moves());
  return { ...made, name };
}
