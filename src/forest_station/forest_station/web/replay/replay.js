// A replay: a bag's frames shown in place of the live crane's, and a second bag as its ghost.
//
// The live crane goes on meanwhile. So the hands of this page let go when a replay begins, and say nothing until it ends.

import { handsOf } from "../hands/hands.js";
import { Bag, RATE } from "./bag.js";
import { Ghost } from "./ghost.js";
import { linkTo, momentOf } from "./link.js";

const AHEAD_S = 3; // of the viewer's time, in which frames are due
const LEAD_S = 0.5; // of the viewer's time, by which the clock may be ahead of the picture
const HISTORY_FRAMES = 60 * RATE; // what the charts show

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];

// Emits "change" when something other than the moment changed, and "moment" with each frame shown.
class Replay extends EventTarget {
  constructor(station) {
    super();
    this.station = station;
    this.bag = null;
    this.ghost = null; // a second bag, laid over it
    this.position = 0; // [frames] since the bag's start
    this.shown = -1; // the frame that is shown
    this.drawn = -1; // the newest frame in a picture
    this.playing = false;
    this.speed = 1;
    this.opening = ""; // name of the bag that is being opened
    this.trouble = "";
    this.liveSignals = [];
    station.on("drawn", (time) => this.#see(time));
    station.on("welcome", ({ signals }) => this.#welcome(signals));
    addEventListener("hashchange", () => this.openLink());
  }

  get active() {
    return this.bag !== null;
  }

  // [s] since the bag's start.
  get time() {
    return Math.max(0, this.shown) / RATE;
  }

  // Whether the next frame is still on its way.
  get waiting() {
    return this.active && this.shown !== Math.floor(this.position);
  }

  // Whether nothing of the wanted moment is seen yet.
  get isLoading() {
    return this.waiting || (this.active && this.station.drawing && this.drawn < 0);
  }

  // Whether the picture is behind, for which the clock waits; a page that draws none does not wait.
  get isAhead() {
    return this.active && this.station.drawing && (this.drawn < 0 || this.shown - this.drawn > LEAD_S * this.speed * RATE);
  }

  // Shows the moment that the page's address names, if it names one.
  async openLink() {
    const moment = momentOf(location.hash);
    if (!moment || location.hash === this.link()) return;
    if (moment.name !== this.bag?.name) await this.open(moment.name);
    if (!this.active) return;
    if (moment.over !== (this.ghost?.bag.name ?? "")) await this.lay(moment.over);
    if (this.ghost) this.ghost.offset = moment.offset;
    this.seek(moment.time);
  }

  async open(name) {
    const bag = await this.#opened(name);
    if (!bag) return;
    handsOf(this.station).release("a replay is shown"); // told to the server while it still hears us
    this.station.live = false;
    this.bag = bag;
    this.playing = false;
    this.#forget();
    this.station.emit("replay", { name });
    this.station.emit("scene", bag.scene);
    this.#goTo(bag.firstFrame);
    requestAnimationFrame((now) => this.#tick(now, bag));
  }

  // Lays a second bag over the first as a ghost; "" takes it away.
  async lay(name) {
    const bag = name ? await this.#opened(name) : null;
    this.ghost = bag && new Ghost(bag);
    if (!this.ghost) this.station.emit("ghost", null);
    this.#repaint();
  }

  // Back to the live crane.
  leave() {
    if (!this.active) return;
    this.bag = this.ghost = null;
    this.playing = false;
    handsOf(this.station).release(""); // what was pressed meanwhile is to be pressed anew
    handsOf(this.station).forget();
    this.station.live = true;
    this.station.setSignals(this.liveSignals);
    for (const kind of ["scene", "ghost", "replay"]) this.station.emit(kind, null);
    history.replaceState(null, "", location.pathname + location.search);
    this.#changed();
  }

  play(playing) {
    if (!this.active) return;
    if (playing && this.position >= this.bag.lastFrame) this.seek(0);
    this.playing = playing;
    this.#changed();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.#changed();
  }

  setOffset(seconds) {
    this.ghost.offset = Number.isFinite(seconds) ? seconds : 0;
    this.#repaint();
  }

  align(topic) {
    this.ghost.align(this.bag, topic);
    this.#repaint();
  }

  seek(seconds) {
    this.#goTo(seconds * RATE);
  }

  step(frames) {
    this.play(false);
    this.#goTo(Math.floor(this.position) + frames);
  }

  // The page's address for what is shown.
  link() {
    if (!this.active) return "";
    return linkTo({ name: this.bag.name, time: this.time, over: this.ghost?.bag.name ?? "", offset: this.ghost?.offset ?? 0 });
  }

  // How far the ghost's tip is from the other [m]; NaN if one is unknown.
  tipDistance() {
    return this.ghost?.tipDistance(this.bag, this.shown) ?? NaN;
  }

  async #opened(name) {
    this.opening = name;
    this.trouble = "";
    this.#changed();
    try {
      const bag = await Bag.open(name, () => this.#repaint());
      return this.opening === name ? bag : null; // another one was asked for meanwhile
    } catch (error) {
      this.trouble = error.message;
      return null;
    } finally {
      if (this.opening === name) this.opening = "";
      this.#changed();
    }
  }

  // A picture was drawn of the frame of a time [s].
  #see(time) {
    if (!this.active || !Number.isFinite(time)) return;
    const before = this.drawn;
    this.drawn = Math.round(time * RATE);
    if (before < 0) this.#changed();
  }

  #welcome(signals) {
    this.liveSignals = signals;
    if (this.active) this.#goTo(this.position);
  }

  #goTo(frame) {
    if (!this.active) return;
    this.position = Math.min(this.bag.lastFrame, Math.max(0, frame));
    this.#forget();
    this.#repaint();
  }

  // The charts begin anew: the time jumped.
  #forget() {
    this.shown = this.drawn = -1;
    this.station.setSignals(this.bag.signals);
  }

  #repaint() {
    if (!this.active) return;
    this.trouble = this.bag.trouble || this.ghost?.bag.trouble || "";
    this.#show(true);
    this.#changed();
  }

  // Moves on with the viewer's clock.
  #tick(now, bag, before = now) {
    if (this.bag !== bag) return;
    if (this.playing && !this.waiting && !this.isAhead) {
      this.position += ((now - before) / 1000) * this.speed * RATE;
      if (this.position >= bag.lastFrame) {
        this.position = bag.lastFrame;
        this.play(false);
      }
    }
    if (this.shown !== Math.floor(this.position)) this.#show(false);
    requestAnimationFrame((next) => this.#tick(next, bag, now));
  }

  // Shows the frame of the position, if it is there; the charts get those on the way, too.
  #show(again) {
    const wanted = Math.floor(this.position);
    this.bag.prepare(wanted, this.playing ? AHEAD_S * this.speed : 0);
    const values = this.bag.frame(wanted);
    if (!values) return;
    if (this.shown !== wanted) {
      const since = this.shown < 0 ? wanted - HISTORY_FRAMES : this.shown + 1;
      for (let number = Math.max(0, since); number < wanted; number++) this.#remember(number);
      this.shown = wanted;
      this.station.show({ time: this.time, values });
    } else if (!again) return;
    this.#showGhost();
    this.dispatchEvent(new Event("moment"));
  }

  #remember(number) {
    if (!this.bag.has(number)) return;
    this.station.history.push({ time: number / RATE, values: this.bag.frame(number) });
  }

  #showGhost() {
    if (!this.ghost) return;
    this.ghost.prepare(this.shown, this.playing ? AHEAD_S * this.speed : 0);
    this.station.emit("ghost", this.ghost.at(this.shown));
  }

  #changed() {
    if (this.active && !this.playing && !this.waiting) history.replaceState(null, "", this.link());
    this.dispatchEvent(new Event("change"));
  }
}

const all = new WeakMap();

// The replay of a station's page: the same one for every panel.
export function replayOf(station) {
  if (!all.has(station)) all.set(station, new Replay(station));
  return all.get(station);
}
