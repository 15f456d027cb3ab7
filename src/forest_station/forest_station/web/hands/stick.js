// A stick on the page: it follows a finger or a mouse, and springs back to its centre.
//
// Its centre is where the finger lands, so that touching it asks for nothing.

import { clamp, withDeadzone } from "./joy.js";

const DEADZONE = 0.06; // a finger that goes straight ahead trembles sideways
const TRAVEL = 0.35; // of the pad's width, to a full deflection
const KNOB = 0.28; // of the pad's width: panels/sticks.css

// Builds a stick; `moved(left, up)` hears its deflections, -1 to 1, as events bring them.
export function makeStick(moved) {
  const pad = document.createElement("div");
  pad.className = "stick";
  pad.dataset.hold = "";
  pad.setAttribute("role", "application");
  const knob = document.createElement("div");
  knob.className = "knob";
  pad.append(knob);
  follow(pad, moved);
  return { pad, show: (left, up) => show(knob, left, up) };
}

// In shares of the knob: to ask for the pad's size would lay the page out anew with every message of the hands.
function show(knob, left, up) {
  const travel = (100 * TRAVEL) / KNOB;
  const place = `translate(${(-left * travel).toFixed(1)}%, ${(-up * travel).toFixed(1)}%)`;
  if (knob.style.transform !== place) knob.style.transform = place;
}

function follow(pad, moved) {
  let finger = null; // {id, x, y}
  const end = (event) => {
    if (finger?.id !== event.pointerId) return;
    finger = null;
    moved(0, 0);
  };
  const move = (event) => {
    if (finger?.id !== event.pointerId) return;
    if (event.buttons === 0) return end(event);
    const travel = TRAVEL * pad.clientWidth;
    const deflection = (way) => withDeadzone(clamp(way / travel), DEADZONE);
    moved(deflection(finger.x - event.clientX), deflection(finger.y - event.clientY));
  };
  pad.addEventListener("pointerdown", (event) => {
    if (finger !== null || event.button !== 0) return;
    event.preventDefault();
    pad.setPointerCapture(event.pointerId);
    finger = { id: event.pointerId, x: event.clientX, y: event.clientY };
  });
  pad.addEventListener("pointermove", move);
  pad.addEventListener("pointerrawupdate", move); // pointermove waits for the next redraw
  for (const lost of ["pointerup", "pointercancel", "lostpointercapture"]) pad.addEventListener(lost, end);
}
