// A replay's controls: banner, time bar, speed, steps, the second bag, and the link to the moment.

import { make, makeButton, setText } from "../elements.js";
import { messageLineOf } from "../message_line.js";
import { bagsOf } from "../replay/bags.js";
import { KEYS_TEXT, listenToKeys } from "../replay/keys.js";
import { makeOverlay } from "../replay/overlay.js";
import { SPEEDS, replayOf } from "../replay/replay.js";
import { makeTimeBar } from "../replay/time_bar.js";

export const place = "bottom";
export const title = "";

export function mount(element, station) {
  const replay = replayOf(station);
  const bags = bagsOf(station);
  const overlay = makeOverlay(replay, bags);
  document.getElementById("scene").append(banner(replay));
  element.append(controls(replay), makeTimeBar(replay), overlay, notes(replay));
  element.title = KEYS_TEXT;
  const section = element.parentElement;
  section.hidden = true;
  replay.addEventListener("change", () => {
    section.hidden = !replay.active;
    document.body.classList.toggle("replaying", replay.active);
  });
  const line = messageLineOf(station);
  replay.addEventListener("change", () => line.say("answer", beforeText(replay), "calm"));
  listenToKeys(replay);
  replay.openLink();
}

function banner(replay) {
  const name = make("span", { className: "name" });
  replay.addEventListener("change", () => setText(name, replay.bag?.name ?? ""));
  const text = make("span", {}, make("strong", {}, "REPLAY"), " of ", name, make("span", { className: "live" }, ". The live crane goes on."));
  const back = makeButton("Back to live", () => replay.leave());
  const element = make("div", { id: "replay_banner", role: "status", hidden: true }, text, back);
  replay.addEventListener("change", () => (element.hidden = !replay.active));
  return element;
}

function controls(replay) {
  const play = makeButton("", () => replay.play(!replay.playing), "play");
  const speed = make("select", { onchange: () => replay.setSpeed(Number(speed.value)) });
  speed.setAttribute("aria-label", "Speed");
  speed.append(...SPEEDS.map((value) => make("option", { value, textContent: `${value}×` })));
  const time = make("output", { className: "time" });
  const told = make("span", { className: "told", role: "status" });
  const follow = () => {
    setText(play, replay.playing ? "Pause" : "Play the recording");
    speed.value = replay.speed;
  };
  const count = () => replay.active && setText(time, timeText(replay));
  replay.addEventListener("change", follow);
  replay.addEventListener("change", count);
  replay.addEventListener("moment", count);
  follow();
  return make(
    "div",
    { className: "controls" },
    named(makeButton("◀", () => replay.step(-1)), "One frame back"),
    play,
    named(makeButton("▶", () => replay.step(1)), "One frame forward"),
    speed,
    time,
    makeButton("Copy link", () => copyLink(replay, told)),
    told,
  );
}

// The time of what is shown, and whether that is on its way.
export function timeText({ time, bag, isLoading }) {
  return `${time.toFixed(2)} of ${bag.seconds.toFixed(2)} s${isLoading ? ", loading" : ""}`;
}

// What is read from the click on a bag until its first moment is shown.
export function beforeText({ active, opening }) {
  return opening && !active ? `The recording ${opening} is being opened: the crane that you see is the live one.` : "";
}

async function copyLink(replay, told) {
  try {
    await navigator.clipboard.writeText(new URL(replay.link(), location.href).href);
    setText(told, "The link to this moment is copied.");
  } catch {
    setText(told, "Copy the address of this page: it names this moment.");
  }
  setTimeout(() => setText(told, ""), 3000);
}

// What is wrong with the bag, or is not shown of it.
function notes(replay) {
  const list = make("ul", { className: "notes" });
  replay.addEventListener("change", () => {
    const texts = [replay.trouble, replay.opening && `${replay.opening} is being opened.`, ...(replay.bag?.notes ?? [])];
    const told = texts.filter(Boolean);
    if (list.dataset.key === JSON.stringify(told)) return;
    list.dataset.key = JSON.stringify(told);
    list.replaceChildren(...told.map((text) => make("li", { textContent: text })));
  });
  return list;
}

function named(button, text) {
  button.setAttribute("aria-label", text);
  button.title = text;
  return button;
}
