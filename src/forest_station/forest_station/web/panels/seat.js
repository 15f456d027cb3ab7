// Who drives, whether the deadman is held, and why nothing moves.

import { make, makeButton, setText } from "../elements.js";
import { handsOf } from "../hands/hands.js";

export const place = "top";
export const title = "";

export function mount(element, station) {
  const hands = handsOf(station);
  const view = {
    driver: make("strong", { className: "driver" }),
    deadman: make("span", { className: "deadman" }),
    why: make("span", { className: "why" }),
    buttons: make("span", { className: "buttons" }),
    answer: make("span", { className: "answer", role: "status" }),
  };
  element.append(view.driver, view.deadman, view.buttons, view.why, view.answer);
  view.why.setAttribute("role", "status");
  const state = { you: null, seat: null, first: true };
  const paint = () => show(view, state, hands, station);
  station.on("welcome", ({ you }) => {
    state.you = you;
    paint();
  });
  station.on("seat", (seat) => {
    state.seat = seat;
    setText(view.answer, "");
    paint();
    if (state.first && seat.driver === null) ask(view, station, "take_seat"); // who opens the page wants to drive
    state.first = false;
  });
  station.on("close", () => {
    state.seat = null;
    paint();
  });
  hands.addEventListener("change", paint);
  paint();
}

function show(view, { you, seat }, hands, station) {
  const { held } = hands.deadman;
  setText(view.driver, driverText(seat));
  view.driver.dataset.drives = Boolean(seat?.you_drive);
  setText(view.deadman, held ? "Deadman held" : "Deadman released");
  view.deadman.dataset.held = held;
  setText(view.why, whyText(seat, hands));
  const wanted = seat ? choices(seat, you) : [];
  const key = JSON.stringify(wanted);
  if (view.buttons.dataset.key === key) return; // a button that is replaced while it is pressed hears no click
  view.buttons.dataset.key = key;
  view.buttons.replaceChildren(
    ...wanted.map(({ text, what, args }) => makeButton(text, () => ask(view, station, what, args))),
  );
}

function driverText(seat) {
  if (!seat) return "No connection";
  if (seat.you_drive) return "You drive";
  return seat.driver === null ? "Nobody drives" : `${seat.driver} drives, you look on`;
}

function whyText(seat, hands) {
  if (!seat) return "The connection to the crane is lost: it stands still. The page goes on trying.";
  if (seat.why_not) return seat.why_not;
  if (seat.you_drive && !hands.deadman.held) return `Hold the deadman: ${hands.deadman.why}.`;
  return "";
}

// What this page can do about the seat.
function choices(seat, you) {
  if (seat.you_drive) {
    const handOver = seat.asking.map((to) => ({ text: `Hand over to ${to}`, what: "leave_seat", args: { to } }));
    return [...handOver, { text: "Leave the seat", what: "leave_seat", args: {} }];
  }
  if (seat.asking.includes(you)) return [];
  return [{ text: seat.driver === null ? "Take the seat" : "Ask for control", what: "take_seat", args: {} }];
}

async function ask(view, station, what, args) {
  const { text } = await station.ask(what, args);
  setText(view.answer, text);
}
