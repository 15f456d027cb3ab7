// Record the live crane, mark what happens, and the list of recordings.

import { make, makeButton, setText } from "../elements.js";
import { bagsOf } from "../replay/bags.js";
import { replayOf } from "../replay/replay.js";

export const place = "left";
export const title = "Recordings";

const LONGEST_MARK = 200;
const [MOST_ROWS, SEARCHED] = [50, 10]; // in the list; recordings from which on it can be searched
const LOST_OF = /(lost \d+)((?:, \d+ of [^,:]+)+)/;
const SLIGHT = 1e-3; // share of messages that may be lost of a bag that figures are taken from

export function mount(element, station) {
  const state = make("p", { className: "state", role: "status" });
  const losses = make("details", { className: "losses", hidden: true }, make("summary", {}, "Lost messages, by topic"), make("p"));
  const answer = make("p", { className: "answer", role: "status" });
  const ask = async (what, args, meanwhile = "") => {
    setText(answer, meanwhile);
    const { ok, text } = await station.ask(what, args);
    setText(answer, ok && what !== "mark" ? "" : text); // the state tells of the recorder already
  };
  element.append(recorder(station, ask), state, losses, marker(station, ask), answer, list(station));
  station.on("recording", (told) => {
    setText(state, stateText(told));
    setText(losses.lastChild, lossesText(told));
    losses.hidden = !lossesText(told);
  });
}

function recorder(station, ask) {
  const name = make("input", { type: "text", placeholder: "name: date and time", maxLength: 64, spellcheck: false });
  name.setAttribute("aria-label", "Name of the recording");
  const stop = async () => {
    setText(button, "Stopping…"); // the recorder writes what is left, which may take seconds
    button.disabled = true;
    await ask("stop_recording", {}, "Stop was heard: what is left is written.");
    if (button.dataset.active === "true") show(true); // refused, or not yet done
  };
  const button = makeButton("Record", () => {
    if (button.dataset.active === "true") return stop();
    return ask("start_recording", name.value ? { name: name.value } : {});
  });
  button.className = "record";
  const show = (active) => {
    button.disabled = false;
    setText(button, active ? "Stop" : "Record");
  };
  station.on("recording", ({ active }) => {
    if (button.dataset.active !== String(active)) show(active); // not each second: a stop may be under way
    button.dataset.active = active;
    name.disabled = active;
    if (active) name.value = "";
  });
  return make("div", { className: "line" }, name, button);
}

// Each topic's losses, as the recorder tells them at the end; "" for none.
export function lossesText({ active, text }) {
  return active ? "" : (LOST_OF.exec(text)?.[2] ?? "").replace(/^, /, "");
}

// How a recording goes, and what became of it: without each topic's losses, but with what they mean.
export function stateText({ active, hears, name, seconds, bytes, text }) {
  if (active && !hears) return `${name}: the recorder starts, and does not hear the crane yet.`;
  if (active) return `${name}: ${/^\d+:/.test(text) ? text : `${clock(seconds)}, ${size(bytes)}.`}`;
  const short = text.replace(/^r/, "R").replace(LOST_OF, (_, lost, topics) => `${lost} in ${counted(topics.split(", ").length - 1, "topic")}`);
  const [, written, lost] = /^Recorded (\d+) messages.* lost (\d+)/.exec(short) ?? [];
  if (written === "0") return `${short}. Nothing was heard: record longer.`;
  return lost > SLIGHT * written ? `${short}. Too many are lost for figures.` : short;
}

const counted = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;

function marker(station, ask) {
  const text = make("input", { type: "text", placeholder: "what happens", maxLength: LONGEST_MARK });
  text.setAttribute("aria-label", "Text of the mark");
  const form = make("form", { className: "line" }, text, make("button", { type: "submit", textContent: "Mark" }));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    ask("mark", { text: text.value.trim() || "mark" });
    text.value = "";
  });
  station.on("recording", ({ active, hears }) => (form.hidden = !(active && hears)));
  form.hidden = true;
  return form;
}

function list(station) {
  const bags = bagsOf(station);
  const replay = replayOf(station);
  const opening = make("p", { className: "answer", role: "status" });
  replay.addEventListener("change", () => setText(opening, openingText(replay)));
  const rows = make("ul", { className: "bags" });
  const told = make("p", { className: "found", role: "status" });
  const search = make("input", { type: "search", placeholder: "search by name or date" });
  search.setAttribute("aria-label", "Search the recordings");
  const show = () => {
    const found = bags.entries.filter((bag) => isFound(bag, search.value));
    setText(told, bags.trouble || foundText(found.length, bags.entries.length, search.value));
    search.hidden = bags.entries.length < SEARCHED;
    rows.replaceChildren(...found.slice(0, MOST_ROWS).map((bag) => row(bag, replay)));
  };
  search.addEventListener("input", show);
  bags.addEventListener("change", show);
  return make("div", {}, opening, search, rows, told, makeButton("Read the list again", () => bags.read()));
}

// Whether a recording's name or date has every word that is searched for.
function isFound(bag, words) {
  const text = `${bag.name} ${when(bag)}`.toLowerCase();
  return words.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

// What the list leaves out, and how to reach it; `found` of `all` recordings are those that are searched for.
export function foundText(found, all, words) {
  if (all === 0) return "There is no recording yet.";
  if (found === 0) return `None of ${all} recordings has "${words.trim()}" in its name or date.`;
  return found > MOST_ROWS ? `These are the newest ${MOST_ROWS} of ${found}: search for the others.` : "";
}

// How the opening of a bag goes, as long as no replay is there to tell.
export function openingText({ active, opening, trouble }) {
  if (active) return "";
  if (opening) return `${opening} is being opened.`;
  return trouble && `The recording cannot be replayed: ${trouble}`;
}

const when = ({ modified }) => new Date(1000 * modified).toLocaleString([], { dateStyle: "medium", timeStyle: "short" });

function row(bag, replay) {
  const { name, bytes, seconds } = bag;
  const told = [when(bag), seconds === null ? "" : clock(seconds), size(bytes)].filter(Boolean).join(" · ");
  return make(
    "li",
    {},
    make("span", { className: "name", textContent: name }),
    make("small", { textContent: told }),
    makeButton("Replay", () => replay.open(name)),
  );
}

function clock(seconds) {
  const whole = Math.floor(seconds);
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

function size(bytes) {
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}
