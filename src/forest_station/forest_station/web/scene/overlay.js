// What lies over the picture: buttons for the views, and what its colours mean.

import { make } from "../elements.js";
import { VIEWS } from "./cameras.js";

const LEGEND = [["wish", "where you asked the tip to go"], ["tip", "where the tip went, 20 s"], ["area", "how far the crane reaches"],
  ["wall", "wall, and where the tip brakes"], ["out", "hose: oil to a cylinder"], ["back", "hose: oil from a cylinder"],
  ["ghost", "crane of the second recording"], ["exercise", "your square"], ["rigid", "crane as it would be unbent"]];
const SLOW = 5; // [1/s] pictures below which the computer is likely to be too busy to drive

// Buttons, and the keys 1 to 4.
export function viewButtons(cameras) {
  const group = document.createElement("div");
  group.className = "views";
  group.setAttribute("role", "group");
  group.setAttribute("aria-label", "View");
  const buttons = VIEWS.map((view, i) => button(view, i + 1, () => cameras.choose(view)));
  const mark = () => buttons.forEach((each, i) => each.setAttribute("aria-pressed", String(VIEWS[i] === cameras.view)));
  cameras.addEventListener("view", mark);
  addEventListener("keydown", (event) => {
    const view = VIEWS[Number(event.key) - 1];
    if (view && !typing(event)) cameras.choose(view);
  });
  mark();
  group.append(...buttons);
  return group;
}

function button(view, key, chosen) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = view;
  made.title = `View: ${view} (key ${key})`;
  made.dataset.view = view;
  made.addEventListener("click", chosen);
  return made;
}

function typing({ target, ctrlKey, altKey, metaKey }) {
  return ctrlKey || altKey || metaKey || target.closest?.("input, select, textarea, [contenteditable]");
}

// What the colours mean. A small window begins without: it would lie over the crane.
export function legend() {
  const items = LEGEND.map(([className, textContent]) => make("li", { className, textContent }));
  const open = !matchMedia("(width < 75rem) or (height < 45rem)").matches;
  return make("details", { className: "legend", open }, make("summary", {}, "Lines"), make("ul", {}, ...items));
}

// The figure of the drawing: pictures per second, and their share of the screen's resolution [1].
export function rateText(rate, share) {
  const figure = `${rate} ${rate === 1 ? "picture" : "pictures"}/s, ${Math.round(100 * share)} % sharp`;
  return rate < SLOW ? `${figure}: click to stop` : figure;
}

// Why there is no picture, and what to do.
export function failureText(text) {
  const options = "--use-angle=swiftshader --enable-unsafe-swiftshader";
  const remedy = /WebGL/.test(text) ? ` Without a graphics processor start Chromium with ${options}.` : "";
  return `The crane cannot be drawn: ${text.replace(/[^.]$/, "$&.")}${remedy}`;
}
