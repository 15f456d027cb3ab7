// Who drives, how the deadman is, and why nothing moves: in words.

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

// How the deadman is, as the server judges it: {state, text}. "pressed": a hand is on it, and it does not count.
//
// here: {held, doubted} of this page's deadman.
export function deadmanState(seat, here) {
  const judged = seat?.deadman.state ?? "waiting";
  if (judged === "held") return { state: "held", text: "Deadman held" };
  if ((here.held || here.doubted) && seat?.you_drive) return { state: "pressed", text: "Deadman does not count: let it go" };
  return { state: judged, text: "Deadman released" };
}

// A cause, if there is one, and what to do.
function sentences(cause, remedy) {
  return cause ? `${cause[0].toUpperCase()}${cause.slice(1)}. ${remedy}` : remedy;
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

// Why nothing moves, or not as fast as it was told to; "" if nothing is in the way.
//
// seat: the newest message, or null; here: {held, doubted, why} of this page's deadman, {deflected}: a stick or a key is
// away from its centre, {grip}: what is held here to drive, its id, {you}, and how it lost the server, {lost};
// stopped: the emergency stop is active; status: armed, factor and limit of controller/status, NaN where unknown, and
// {axis}: at its limit, "" if nobody knows; cause: why the controller stands still, "" if nobody knows.
export function whyText(seat, here, stopped, status, cause = "") {
  if (!seat) return here.lost || "The page asks for the crane. If this lasts: does scripts/station.sh run?";
  if (stopped) return ""; // its own panel says so
  if (seat.why_not) return seat.why_not;
  if (seat.asking.includes(here.you)) return `${seat.driver} is asked to hand over.`;
  if (!seat.you_drive) return seat.driver === null ? "Take the seat to drive." : "";
  if (seat.deadman.state !== "held") {
    if (here.held) return seat.deadman.text;
    if (here.deflected && !here.doubted) return `Nothing moves without the deadman: let go of sticks and keys, then hold ${here.grip}.`;
    return sentences(here.why, here.doubted ? "Let go of the deadman, then hold it again." : seat.deadman.text);
  }
  if (status.armed === 0) return sentences(cause && `the controller stopped: ${cause}`, "Centre the sticks, then go on.");
  if (!(status.factor < 1)) return "";
  const percent = Math.round(100 * status.factor);
  const held = percent === 0 ? "Held back" : `Slowed to ${percent} %`;
  if (status.limit === JOINT) return `${held}: the ${status.axis ? `${status.axis} ` : ""}joint ${percent === 0 ? "is at" : "nears"} its limit.`;
  return LIMITS[status.limit] ? `${held} by ${LIMITS[status.limit]}.` : "";
}
