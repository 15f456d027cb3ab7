// What is in the way and what to do next, judged once for every panel that says so.

import { handsOf } from "./hands.js";
import { RATE, adviceFor, isStanding, lostText, standingCause } from "./why.js";
import { axisAtLimit, axisAtRate } from "../scene/axes.js";

const PERIOD_MS = 200; // the controller's status comes with the frames
const MOMENT_MS = 300; // in which a controller arms: it hears of the deadman a little later than the page

// Emits "change" when something may be said anew.
class Advice extends EventTarget {
  #disarmed = NaN; // since when the controller lets nothing move although the deadman is held [ms]

  constructor(station, hands) {
    super();
    Object.assign(this, { station, hands, you: null, seat: null, stopped: false, phase: "", parts: [], logged: null, lost: "" });
    const hear = (kind, act) =>
      station.on(kind, (detail) => {
        act(detail);
        this.#judge();
      });
    hear("welcome", ({ you }) => (this.you = you));
    hear("seat", (seat) => (this.seat = seat));
    hear("emergency_stop", ({ active }) => (this.stopped = active));
    hear("taught_work", ({ phase }) => (this.phase = phase));
    hear("diagnostics", ({ parts }) => (this.parts = parts));
    hear("log", ({ text }) => isStanding(text) && (this.logged = { text, at: performance.now() }));
    hear("close", (reason) => {
      if (this.seat || reason) this.lost = lostText(reason);
      this.seat = null;
    });
    hear("replay", () => {});
    hands.addEventListener("change", () => this.#judge());
    setInterval(() => this.#judge(), PERIOD_MS);
    this.#judge();
  }

  // This page's hands, as `adviceFor` asks for them.
  get here() {
    const { held, doubted, why } = this.hands.deadman;
    const { deflected, aside, grip, lateness } = this.hands;
    const often = lateness.isOften(performance.now());
    const now = { replays: !this.station.live, plays: this.phase === "waiting" };
    return { held, doubted, why, deflected, aside, grip, often, you: this.you, lost: this.lost, ...now };
  }

  #judge() {
    const now = performance.now();
    const cause = standingCause(this.parts, this.logged, now);
    this.said = adviceFor(this.seat, this.here, this.stopped, this.#status(now), cause); // {text, order, moves}
    this.dispatchEvent(new Event("change"));
  }

  #status(now) {
    const value = (label) => this.station.value(`controller/status/${label}`);
    const axis = this.#axisAt(value("limit"));
    const isHeld = this.seat?.deadman.state === "held" && this.hands.deadman.held;
    this.#disarmed = isHeld && value("armed") === 0 ? this.#disarmed || now : NaN;
    return { disarmed: now - this.#disarmed >= MOMENT_MS, factor: value("factor"), limit: value("limit"), axis };
  }

  // The axis whose limit acts; "" if nobody knows.
  #axisAt(limit) {
    const value = (name) => this.station.value(name);
    if (limit === RATE) return axisAtRate(value);
    const joints = this.station.scene?.joints;
    return joints ? axisAtLimit(joints, value) : "";
  }
}

const all = new WeakMap();

// The advice of a station's page: the same for every panel.
export function adviceOf(station) {
  if (!all.has(station)) all.set(station, new Advice(station, handsOf(station)));
  return all.get(station);
}
