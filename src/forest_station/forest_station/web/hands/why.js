// Who drives, how the deadman is, why nothing moves, and what to do next: in words; pure.

import { ADVICE, isLateness } from "./late.js";

// By code of `limit` on controller/status: docs/reference/codes.md.
export const RATE = 1;
const [JOINT, WALL] = [2, 5];
const LIMITS = [
  "", "", "", "a singular pose", "the flow of the pumps", "", "",
  "the load: inward, down and sideways are free", "an overload: let go of the deadman, then put the load down", "the joystick's late link",
];

export function driverText(seat) {
  if (!seat) return "No connection";
  if (seat.you_drive) return "You drive";
  return seat.driver === null ? "Nobody drives" : `${seat.driver} drives, you look on`;
}

// What is said when the connection ends, by the server's reason; "": it told none.
export function lostText(reason) {
  const what = reason ? `${reason} Its terminal says why.` : "The crane stands still until the page is connected again.";
  return `${what} ${reason ? "Start scripts/station.sh anew." : "If this lasts, look at the terminal of scripts/station.sh."}`;
}

// How the deadman is: {state, text}. It is held when the server says so and, where this page drives, its hands do as well.
// "pressed": a hand is on it, and it does not count, or the server is about to hear of it.
//
// here: {held, doubted} of this page's deadman.
export function deadmanState(seat, here) {
  const judged = seat?.deadman.state ?? "waiting";
  const pressed = here.held || here.doubted;
  if (judged === "held" && (here.held || !seat.you_drive)) return { state: "held", text: "Deadman held" };
  const begins = judged === "ready" && !here.doubted;
  if (pressed && seat?.you_drive) return { state: "pressed", text: begins ? "Deadman pressed" : "Deadman does not count" };
  return { state: judged === "held" ? "waiting" : judged, text: "Deadman released" };
}

const LONGEST_NAME = 30;
const BACK_TO_LIVE = "Press Back to live to drive.";

// What brings all sticks to their centres. A worn gamepad does not come back by itself.
function centre({ aside }) {
  if (!aside) return "Let go of sticks and keys";
  return `Let go of ${aside.split(" (")[0].slice(0, LONGEST_NAME)}, or calibrate it (Gamepads and joysticks)`;
}

// What a hand has to let go of first; "" for a hand at rest.
function letGo({ held, doubted, deflected, grip, aside }) {
  if (held || doubted) return `Let go of ${grip}.`;
  return deflected ? `${centre({ aside })}.` : "";
}

// What to do next for the deadman to count: one thing, and none that is done already.
function deadmanOrder({ deadman }, here) {
  const { held, doubted, deflected, grip } = here;
  if (doubted || (held && deadman.state === "waiting")) return letGo(here);
  if (held) return ""; // the server is about to hear of it
  if (deflected) return `${centre(here)}: nothing moves without the deadman.`;
  if (deadman.state !== "ready") return "";
  return here.plays ? `Hold ${grip}, and leave the sticks alone: the cycle goes on.` : `Hold ${grip}, then move a stick.`;
}

// A cause, if there is one, and what to do.
function sentences(cause, remedy) {
  const begun = cause && `${cause[0].toUpperCase()}${cause.slice(1)}`.replace(/[^.?]$/, "$&.");
  return [begun, remedy].filter(Boolean).join(" ");
}

const STANDING = /^standing still: /; // begins what a controller logs
const RECENT_MS = 10_000;

// Why the controller stands still: what it says at the moment, or has logged lately, for a short trouble is over before it is read.
//
// parts: of the newest diagnostics; logged: {text, at} of the newest line that begins so, or null; now: as `at` [ms].
export function standingCause(parts, logged, now) {
  const part = parts.find(({ name, level }) => level === "error" && /controller: /.test(name));
  if (part) return part.text;
  return logged && now - logged.at < RECENT_MS ? logged.text.replace(STANDING, "") : "";
}

export const isStanding = (text) => STANDING.test(text);

// Whether nothing is in the way of what a text tells to do.
export const isHint = (text) => text.startsWith("Hold ") || text.endsWith(BACK_TO_LIVE);

// What is in the way, or slows the tip, and the one thing to do next: {text, order, moves}. `text` holds the order, too;
// "" if nothing is in the way; `moves`: a stick would move the tip.
//
// seat: the newest message, or null; here: {held, doubted, why} of this page's deadman, {deflected}: a stick or a key is
// away from its centre, {aside}: the gamepad that alone is, {grip}: what is held here to drive, {often}: hands came too late
// lately, its id, {you}, and how it lost the server, {lost}, {replays}: it shows a bag, and {plays}: a cycle waits for the
// deadman; stopped: the emergency stop is active; status: {disarmed}: the controller lets no stick move anything, for more
// than a moment, factor and limit of controller/status, NaN where unknown, and {axis}: at its limit, "" if nobody knows;
// cause: why the controller stands still, "" if nobody knows.
export function adviceFor(seat, here, stopped, status, cause = "") {
  const said = (text, order = "") => ({ text: sentences(text, order), order, moves: false });
  if (!seat) return said(here.lost || "The page asks for the crane. If this lasts: does scripts/station.sh run?");
  if (stopped) return { ...said("", seat.you_drive ? letGo(here) || "Press Reset." : ""), text: "" }; // the stop's own line says it
  if (seat.why_not) return said(seat.why_not);
  if (seat.asking.includes(here.you)) return said(`${seat.driver} is asked to hand over.`);
  if (here.replays) return seat.you_drive ? said("a replay is shown", letGo(here) || BACK_TO_LIVE) : said("");
  if (!seat.you_drive) return said("", seat.driver === null ? "Take the seat to drive." : "");
  if (deadmanState(seat, here).state !== "held") return notHeld(seat, here, said);
  if (status.disarmed) return said(cause && `the controller stopped: ${cause}`, disarmedOrder(here, cause));
  return { text: slowedText(status), order: "", moves: true };
}

// Who is often too late needs another computer's time more than another press.
function notHeld(seat, here, said) {
  const cause = here.why || seat.deadman.cause;
  const order = deadmanOrder(seat, here);
  const pressed = here.held || here.doubted;
  return { ...said(cause, here.often && isLateness(cause) && !pressed ? ADVICE : order), order };
}

// Centred sticks arm a controller, but not behind a trouble: then the deadman is to be let go.
function disarmedOrder(here, cause) {
  return here.deflected && !cause ? letGo({ deflected: true, aside: here.aside }) : letGo(here);
}

// A wall takes away the speed towards it, and no share of the rest: its factor is 1.
function slowedText({ factor, limit, axis }) {
  if (limit === WALL) return "Held back by a wall: along it and away from it the tip is free.";
  const percent = Math.round(100 * factor);
  if (!(percent < 100)) return "";
  const held = percent === 0 ? "Held back" : `Slowed to ${percent} %`;
  if (limit === JOINT) return `${held}: the ${axis ? `${axis} ` : ""}joint ${percent === 0 ? "is at" : "nears"} its limit.`;
  if (limit === RATE) return `${held} by ${axis ? `the ${axis}` : "a"} joint's greatest speed.`;
  return LIMITS[limit] ? `${held} by ${LIMITS[limit]}.` : "";
}
