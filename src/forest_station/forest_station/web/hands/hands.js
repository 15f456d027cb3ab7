// The hands of this page: sticks, keys, gamepads and the deadman, told to the server while this page drives.
//
// 50 times a second and at once on a change, straight from the event to the socket: no redraw is waited for.

import { Deadman, hung } from "./deadman.js";
import { Gamepads } from "./gamepads.js";
import { watchInputLoss } from "./input_loss.js";
import { CENTRED, buttonBits, mergeAxes } from "./joy.js";
import { Keyboard } from "./keyboard.js";
import { Lateness, TOO_LATE, isLateness } from "./late.js";
import { handsMessage } from "./message.js";

const [PERIOD_MS, TICK_MS] = [20, 15]; // a clock that was late does not make the next one wait
const SHORTEST_MS = 4; // between two messages of moving sticks: a mouse may move 1000 times a second
const KEY = "the key";
const FINGERS = matchMedia("(pointer: coarse)").matches;

// Emits "change" when the axes or the deadman changed, and "latency" with the round trip [ms].
class Hands extends EventTarget {
  constructor(station) {
    super();
    this.station = station;
    this.deadman = new Deadman();
    this.lateness = new Lateness();
    this.gamepads = new Gamepads();
    this.axes = CENTRED;
    this.buttons = 0;
    this.drives = false;
    this.sticks = new Map(); // name → axes of a stick on the page
    this.keyboard = new Keyboard(() => this.update());
    this.number = 0;
    this.pong = 0; // number of the newest answer: by it the server knows how slow the network is
    this.pads = []; // keys of the gamepads with a deadman that were there
    this.aside = ""; // the gamepad that alone is away from its centre
    this.state = ""; // of the last look
    this.sent = { at: -Infinity, state: "", held: false };
    this.asked = new Map(); // number → when [ms]
    this.looked = performance.now();
    watchInputLoss((why) => this.#doubt(why));
    station.on("seat", (seat) => this.#sit(seat));
    station.on("pong", ({ number }) => this.#measure(number));
    station.on("close", () => this.#disconnect());
    setInterval(() => this.#tick(), PERIOD_MS);
    this.clock = new Worker("/web/hands/clock.js"); // for a touch holds back the page's own timers
    this.clock.onmessage = () => this.#tick();
  }

  // Holds the deadman, or lets it go, on behalf of a control of the page.
  hold(holder, pressed) {
    this.deadman.set(holder, pressed);
    this.update();
  }

  // Lets the deadman go for everybody: whoever held it has to press anew.
  release(why) {
    this.deadman.release(why);
    this.update();
  }

  // What made the deadman be let go is over.
  forget() {
    this.deadman.why = "";
    this.dispatchEvent(new Event("change"));
  }

  // A stick or a key is away from its centre.
  get deflected() {
    return this.axes.some((axis) => axis !== 0);
  }

  // What a person holds here to drive.
  get grip() {
    if (FINGERS) return "HOLD TO DRIVE";
    return this.pads.length > 0 ? "the left Shift key or the gamepad's left shoulder" : "the left Shift key";
  }

  moveStick(name, axes) {
    this.sticks.set(name, axes);
    this.update();
  }

  // Looks at all hands, judges, and tells.
  update() {
    const now = performance.now();
    const pads = this.gamepads.read();
    this.deadman.set(KEY, this.keyboard.holdsDeadman);
    this.#hearPads(pads.deadmen);
    this.#judge(now);
    const keys = this.keyboard.step((now - this.looked) / 1000);
    this.looked = now;
    const here = mergeAxes([...this.sticks.values(), keys]);
    this.aside = here.some((axis) => axis !== 0) ? "" : (pads.aside[0] ?? "");
    this.axes = mergeAxes([here, pads.axes]);
    this.buttons = buttonBits(pads.pressed, this.deadman.held);
    this.#tell(now);
  }

  // Two clocks tick: the first one counts.
  #tick() {
    if (performance.now() - this.looked >= TICK_MS) this.update();
  }

  // Lets go of what must not count, also of what was pressed just now.
  #judge(now) {
    if (this.deadman.held && hung(this.looked, now)) this.#beLate(now);
    if (document.hidden || !document.hasFocus()) this.deadman.release("the page is not in front");
    if (!this.station.live) this.deadman.release("a replay is shown");
  }

  #beLate(now) {
    this.lateness.count(now);
    this.deadman.release(TOO_LATE);
  }

  // Nobody knows any more what is held, and how it was let go.
  #doubt(why) {
    this.keyboard.clear();
    this.release(why);
  }

  #hearPads(deadmen) {
    for (const gone of this.pads.filter((key) => !deadmen.has(key))) this.deadman.set(gone, false);
    for (const [key, pressed] of deadmen) this.deadman.set(key, pressed);
    this.pads = [...deadmen.keys()];
  }

  #tell(now) {
    const held = this.deadman.held;
    const state = `${held} ${this.deadman.doubted} ${this.buttons} ${this.axes} ${this.keyboard.speed}`;
    if (state !== this.state) this.dispatchEvent(new Event("change"));
    this.state = state;
    if (this.drives && this.#isDue(now, state, held)) this.#send(now, state, held);
  }

  #isDue(now, state, held) {
    const waited = now - this.sent.at;
    if (held !== this.sent.held) return true;
    return waited >= PERIOD_MS - 1 || (state !== this.sent.state && waited >= SHORTEST_MS);
  }

  #send(now, state, held) {
    const number = ++this.number;
    const bytes = handsMessage({ number, time: now, held, axes: this.axes, buttons: this.buttons, pong: this.pong });
    if (this.station.sendHands(bytes)) this.asked.set(number, now);
    this.sent = { at: now, state, held };
  }

  #sit({ you_drive: drives, deadman }) {
    if (drives && isLateness(deadman.cause) && this.deadman.held) this.#beLate(performance.now()); // the server found out
    if (drives !== this.drives) this.deadman.release(drives ? "control was taken over" : "control was handed over");
    this.drives = drives;
    this.dispatchEvent(new Event("change"));
  }

  #disconnect() {
    this.pong = 0;
    this.asked.clear();
    this.release("the connection was lost");
  }

  #measure(number) {
    this.pong = number;
    if (!this.asked.has(number)) return;
    const roundTrip = performance.now() - this.asked.get(number);
    for (const older of this.asked.keys()) if (older <= number) this.asked.delete(older);
    this.dispatchEvent(new CustomEvent("latency", { detail: roundTrip }));
  }
}

const all = new WeakMap();

// The hands of a station's page: the same ones for every panel.
export function handsOf(station) {
  if (!all.has(station)) all.set(station, new Hands(station));
  return all.get(station);
}
