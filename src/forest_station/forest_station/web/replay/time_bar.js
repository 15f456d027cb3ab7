// The bar of a replay: where it is, and what was marked when.

import { make } from "../elements.js";
import { RATE } from "./bag.js";

const MOST_TICKS = 200; // more stand too close together to be told apart

// Returns the bar's element; it follows the replay.
export function makeTimeBar(replay) {
  const slider = make("input", { type: "range", min: 0, step: 1, className: "slider" });
  slider.setAttribute("aria-label", "Time of the replay");
  slider.addEventListener("input", () => replay.seek(slider.valueAsNumber / RATE));
  const ticks = make("div", { className: "ticks" });
  let bag = null;
  const follow = () => {
    if (!replay.active) return;
    if (bag !== replay.bag) {
      bag = replay.bag;
      slider.max = bag.lastFrame;
      ticks.replaceChildren(...bag.events.slice(0, MOST_TICKS).map((event) => tick(replay, event)));
    }
    slider.value = Math.floor(replay.position);
    slider.setAttribute("aria-valuetext", `${replay.time.toFixed(2)} s`);
  };
  replay.addEventListener("change", follow);
  replay.addEventListener("moment", follow);
  return make("div", { className: "bar" }, ticks, slider);
}

function tick(replay, [time, text]) {
  const told = `${time.toFixed(2)} s: ${text}`;
  const button = make("button", { type: "button", title: told, className: "tick", onclick: () => replay.seek(time) });
  button.setAttribute("aria-label", told);
  button.style.left = `${(100 * time) / Math.max(1e-9, replay.bag.seconds)}%`;
  return button;
}
