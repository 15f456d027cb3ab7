// Taught work in words: what is going on, and what a person can do about it; pure.

const NONE = "Nothing is played. Choose a cycle, or teach one below.";

const CONFIRMED = /, until a person confirms\.?$/;

// What a step of the grapple waits for: its time, or a person.
function holdingText(text, simulated) {
  if (!CONFIRMED.test(text)) return text;
  const where = simulated ? " The simulated grapple is worked in Load, by Grasp a log and Drop it." : "";
  return `${text.replace(CONFIRMED, ".")}${where} Press Confirm when it has.`;
}

// What is going on, of the newest `taught_work`; simulated: the crane is.
export function stateText({ there, phase, cycle, segment, text }, simulated = false) {
  if (!there) return text;
  if (phase === "holding") return holdingText(text, simulated);
  if (phase === "waiting") return `${cycle}: centre the sticks and hold the deadman.`;
  if (phase === "running") return `${cycle}: ${segment}. Any stick pauses it.`;
  if (phase === "paused") return `${text} To go on: Resume, with centred sticks, and hold the deadman.`;
  if (phase === "recording") return `${cycle}: a path is taught. Hold the deadman and drive, then keep the path.`;
  return phase === "finished" ? `${cycle} is finished.` : NONE;
}

const PLAY = { what: "play_cycle", text: "Play", drives: true };
const PAUSE = { what: "pause_cycle", text: "Pause" };
const RESUME = { what: "resume_cycle", text: "Resume", drives: true };
const END = { what: "stop_cycle", text: "End" };

// What can be asked for in a phase: {what, text, drives: by the driver alone}.
export function actionsIn(phase) {
  if (phase === "waiting" || phase === "running") return [PAUSE, END];
  if (phase === "paused") return [RESUME, END];
  if (phase === "holding") return [{ ...RESUME, text: "Confirm" }, END];
  if (phase === "recording") return [{ ...END, text: "Keep the path" }];
  return [PLAY];
}

// Whether the crane is about a cycle: then no other is taught or played.
export const isBusy = (phase) => ["waiting", "running", "holding", "recording"].includes(phase);

// How far the tip is; "" where nobody tells. Lengths [m].
export function progressText({ way, length, away }) {
  if (!(length > 0)) return "";
  return `${way.toFixed(2)} of ${length.toFixed(2)} m, ${(1000 * away).toFixed(0)} mm beside the path`;
}
