// The crane in three dimensions. The picture is drawn by a worker (painter.js); here are its canvas, the cameras, and
// the text over it.

import { standingCause } from "../hands/why.js";
import { Cameras } from "./cameras.js";
import { Labels } from "./labels.js";
import { failureText, legend, rateText, viewButtons } from "./overlay.js";

const FINEST = 2; // pixels of the screen per pixel of the page: more cannot be seen at 1 m
const WALLS = ["workspace", "tip_speed"]; // parameters of the controller that the scene depends on
const LONGEST_S = 1; // of a step of the cameras
const STILL = 1e-4; // [m], [1], [deg] by which a camera that stands may differ

// Draws a scene in an element, which then tells where the drawn tip is: `element.tipPosition()` [m] in the base frame.
export async function drawScene(element, station, scene) {
  const canvas = document.createElement("canvas");
  if (!canvas.transferControlToOffscreen) throw new Error("This browser cannot draw the crane: it has no OffscreenCanvas.");
  element.dataset.machine = scene.machine;
  element.append(canvas);
  const view = new View(element, canvas, station, scene);
  element.tipPosition = () => view.tip;
}

class View {
  constructor(element, canvas, station, scene) {
    this.element = element;
    this.station = station;
    this.tip = [NaN, NaN, NaN];
    this.episode = 0; // counts what frames are of: the live crane, a replay
    this.drawn = JSON.stringify(scene);
    this.cameras = new Cameras(canvas, scene);
    this.labels = new Labels(overlay(element, "labels"));
    this.drawing = station.drawing = true; // a person may stop it: a busy computer drives better without
    this.rate = this.#rateButton();
    this.rate.textContent = "the first picture is on its way";
    element.append(viewButtons(this.cameras), legend());
    this.painter = new Worker("/web/scene/painter.js", { type: "module" });
    this.painter.onmessage = ({ data }) => this.#hear(data);
    this.painter.onerror = () => this.#fail("its painter did not start.");
    const offscreen = canvas.transferControlToOffscreen();
    this.painter.postMessage({ kind: "start", canvas: offscreen, scene }, [offscreen]);
    this.#follow();
  }

  #follow() {
    new ResizeObserver(() => this.#resize()).observe(this.element);
    document.addEventListener("visibilitychange", () => this.#sayVisible());
    addEventListener("pagehide", () => this.cameras.keep());
    this.station.on("signals", () => this.#signals());
    this.station.on("frame", ({ time, values }) => this.#sayValues({ kind: "frame", time, live: this.station.live }, values));
    this.station.on("ghost", (detail) => this.#ghost(detail));
    this.station.on("exercise", (exercise) => this.#exercise(exercise));
    this.station.on("taught", (taught) => this.#say({ kind: "taught", taught }));
    this.station.on("diagnostics", ({ parts }) => this.#trouble(this.station.live ? standingCause(parts, null, 0) : ""));
    this.station.on("parameters", ({ nodes }) => this.#settings(nodes.controller ?? {}));
    this.station.on("replay", (replay) => this.#begin(replay ? "replay" : "live"));
    this.station.on("scene", (detail) => this.#change(detail ?? this.station.scene));
    this.#signals();
    this.#resize();
    this.then = performance.now();
    this.cameras.addEventListener("view", () => this.#stepSoon());
    this.cameras.jump();
    this.#step(this.then); // the first picture is seen from there
  }

  // A square is looked at as long as it is there: from elsewhere it is a line.
  #exercise(exercise) {
    const isNew = exercise && !("exercise" in this.element.dataset);
    this.element.toggleAttribute("data-exercise", Boolean(exercise));
    this.#cover();
    if (isNew) this.cameras.watch(exercise.corners, exercise.size);
    else if (!exercise) this.cameras.watch(null);
    this.#say({ kind: "exercise", exercise });
  }

  // What lies over a narrow picture hides what is behind it: the exercise is shown below.
  #cover() {
    const text = this.element.querySelector(":scope > #first_minute");
    const bottom = text ? text.offsetTop + text.offsetHeight : 0;
    this.cameras.covered = Math.min(0.5, bottom / Math.max(1, this.element.clientHeight));
  }

  // The figure of the drawing, which stops it and lets it go on.
  #rateButton() {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "rate";
    button.textContent = "the first picture is on its way";
    button.title = "Pictures drawn, and their resolution. A click stops the drawing: a busy computer drives better without.";
    button.addEventListener("click", () => {
      this.drawing = this.station.drawing = !this.drawing;
      this.element.toggleAttribute("data-undrawn", !this.drawing);
      this.labels.show([]);
      button.textContent = this.drawing ? "the next picture is on its way" : "The drawing is stopped: click to draw.";
      this.#sayVisible();
    });
    this.element.append(button);
    return button;
  }

  #sayVisible() {
    this.#say({ kind: "visible", visible: this.drawing && !document.hidden });
  }

  // What is told each second goes to the painter when it changes.
  #trouble(trouble) {
    if (trouble !== this.trouble) this.#say({ kind: "trouble", trouble });
    this.trouble = trouble;
  }

  #say(message) {
    this.painter.postMessage(message);
  }

  #signals() {
    this.#say({ kind: "signals", names: [...this.station.signals.keys()] });
  }

  // Values may be a window into many frames: only they go, and without a copy on the way.
  #sayValues(message, values) {
    const own = Float32Array.from(values);
    this.painter.postMessage({ ...message, values: own }, [own.buffer]);
  }

  // Its scene goes once: a copy of each one would be another machine to the painter.
  #ghost(detail) {
    this.element.toggleAttribute("data-ghost", Boolean(detail));
    if (!detail) {
      this.ghostScene = null;
      return this.#say({ kind: "ghost" });
    }
    const fresh = detail.scene && detail.scene !== this.ghostScene;
    if (fresh) this.ghostScene = detail.scene;
    const names = detail.signals.map(([name]) => name);
    return this.#sayValues({ kind: "ghost", names, scene: fresh ? detail.scene : null }, detail.values);
  }

  // Walls and slow zones are as the controller is set; the server draws up the scene anew when that changes.
  async #settings(controller) {
    const set = WALLS.map((name) => controller[name]?.value);
    if (set.includes(undefined) || set.join() === this.set) return;
    this.set = set.join();
    const response = await fetch("/scene.json");
    if (!response.ok) return;
    this.station.scene = await response.json();
    if (this.station.live) this.#change(this.station.scene);
  }

  // From here on come frames of something else: until one of them is drawn, what is drawn says nothing of it.
  #begin(what) {
    this.episode++;
    this.element.dataset.awaits = what;
    this.labels.show([]);
    this.#say({ kind: "begin", episode: this.episode });
  }

  // A scene like the one that is drawn is drawn already: to make it anew takes seconds on a busy computer.
  #change(scene) {
    this.element.dataset.machine = scene.machine;
    this.cameras.frame(scene);
    const text = JSON.stringify(scene);
    if (text === this.drawn) return;
    this.drawn = text;
    this.#say({ kind: "scene", scene });
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    this.#cover();
    this.cameras.resize(width, height);
    this.labels.resize();
    this.#say({ kind: "size", width, height, ratio: Math.min(FINEST, devicePixelRatio) });
  }

  // Has the cameras step once: after each picture, for the painter needs no more, and when somebody moves them.
  #stepSoon() {
    if (this.stepping) return;
    this.stepping = true;
    requestAnimationFrame((now) => this.#step(now));
  }

  #step(now) {
    this.stepping = false;
    const seconds = Math.min(LONGEST_S, (now - this.then) / 1000);
    this.then = now;
    const swing = this.station.value("joint_states/swing.position");
    this.cameras.step(seconds, Number.isFinite(swing) ? swing : 0, this.tip.every(Number.isFinite) ? this.tip : null);
    const pose = this.cameras.pose();
    const told = [...pose.position, ...pose.quaternion, pose.fov];
    if (this.told?.every((value, i) => Math.abs(value - told[i]) < STILL)) return;
    this.told = told;
    this.#say({ kind: "camera", ...pose });
  }

  #hear(message) {
    if (message.kind === "failed") return this.#fail(message.text);
    if (!this.drawing || (this.episode > 0 && message.episode !== this.episode)) return this.#stepSoon(); // it was on its way
    delete this.element.dataset.awaits;
    this.station.emit("drawn", message.time);
    this.tip = message.tip;
    this.labels.show(message.labels);
    this.rate.textContent = rateText(message.rate, message.share);
    this.element.dataset.rate = message.rate;
    this.#stepSoon();
  }

  #fail(text) {
    this.station.drawing = false;
    this.rate.textContent = failureText(text);
    this.rate.classList.add("failed");
    this.element.dataset.failed = text;
  }
}

function overlay(element, name) {
  const added = document.createElement("div");
  added.className = name;
  element.append(added);
  return added;
}
