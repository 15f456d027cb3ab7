// Who drives, how the deadman is, and why nothing moves: in words.

import { ADVICE, isLateness } from "./late.js";

// By code of `limit` on controller/status: docs/reference/codes.md.
const JOINT = 2;
const LIMITS = [
  "", "a joint's greatest speed", "", "a singular pose", "the flow of the pumps", "a wall", "",
  "the load: inward, down and sideways are free", "an overload: centre the sticks, then put the load down", "the joystick's late link",
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

// What to do next for the deadman to count: one thing, and none that is done already.
//
// here: {held, doubted, deflected, grip} as for `whyText`.
export function deadmanOrder({ deadman }, { held, doubted, deflected, grip }) {
  if (doubted || (held && deadman.state === "waiting")) return `Let go of ${grip}.`;
  if (held) return ""; // the server is about to hear of it
  if (deflected) return "Let go of sticks and keys: nothing moves without the deadman.";
  return deadman.state === "ready" ? `Hold ${grip}, then move a stick.` : "";
}

// A cause, if there is one, and what to do.
function sentences(cause, remedy) {
  const begun = cause && `${cause[0].toUpperCase()}${cause.slice(1)}`.replace(/[^.]$/, "$&.");
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

// Why nothing moves, or not as fast as it was told to, and the one thing to do next; "" if nothing is in the way.
//
// seat: the newest message, or null; here: {held, doubted, why} of this page's deadman, {deflected}: a stick or a key is
// away from its centre, {grip}: what is held here to drive, {often}: hands came too late lately, its id, {you}, and how it
// lost the server, {lost}; stopped: the emergency stop is active; status: armed, factor and limit of controller/status, NaN
// where unknown, and {axis}: at its limit, "" if nobody knows; cause: why the controller stands still, "" if nobody knows.
export function whyText(seat, here, stopped, status, cause = "") {
  if (!seat) return here.lost || "The page asks for the crane. If this lasts: does scripts/station.sh run?";
  if (stopped) return ""; // its own panel says so
  if (seat.why_not) return seat.why_not;
  if (seat.asking.includes(here.you)) return `${seat.driver} is asked to hand over.`;
  if (!seat.you_drive) return seat.driver === null ? "Take the seat to drive." : "";
  if (deadmanState(seat, here).state !== "held") return notHeldText(seat, here);
  if (status.armed === 0) return sentences(cause && `the controller stopped: ${cause}`, here.deflected ? "Let go of sticks and keys." : "");
  if (!(status.factor < 1)) return "";
  const percent = Math.round(100 * status.factor);
  const held = percent === 0 ? "Held back" : `Slowed to ${percent} %`;
  if (status.limit === JOINT) return `${held}: the ${status.axis ? `${status.axis} ` : ""}joint ${percent === 0 ? "is at" : "nears"} its limit.`;
  return LIMITS[status.limit] ? `${held} by ${LIMITS[status.limit]}.` : "";
}

// Who is often too late needs another computer's time more than another press.
function notHeldText(seat, here) {
  const cause = here.why || seat.deadman.cause;
  const order = deadmanOrder(seat, here);
  const pressed = here.held || here.doubted;
  return sentences(cause, here.often && isLateness(cause) && !pressed ? ADVICE : order);
}
