// What lies over the picture: buttons for the views, and what its colours mean.

import { make } from "../elements.js";
import { VIEWS } from "./cameras.js";

const LEGEND = [["wish", "commanded path"], ["tip", "tip, last 20 s"], ["area", "reach"], ["wall", "wall, slow zone, the load's reach"],
  ["out", "oil to the actuator"], ["back", "oil back"], ["ghost", "ghost: the second bag"],
  ["exercise", "your square"], ["rigid", "as if no link bent"]];
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
  const figure = `${rate} ${rate === 1 ? "picture" : "pictures"}/s · ${Math.round(100 * share)} %`;
  return rate < SLOW ? `${figure}: click to stop the drawing` : figure;
}
