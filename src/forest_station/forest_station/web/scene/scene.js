// The crane in three dimensions. The picture is drawn by a worker (painter.js); here are its canvas, the cameras, and
// the text over it.

import { Cameras } from "./cameras.js";
import { Labels } from "./labels.js";
import { legend, viewButtons } from "./overlay.js";

const FINEST = 2; // pixels of the screen per pixel of the page: more cannot be seen at 1 m
const LONGEST_S = 0.1; // of a step of the cameras

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
    this.home = scene;
    this.tip = [NaN, NaN, NaN];
    this.cameras = new Cameras(canvas, scene);
    this.labels = new Labels(overlay(element, "labels"));
    this.rate = overlay(element, "rate");
    element.append(viewButtons(this.cameras), legend());
    this.painter = new Worker("/web/scene/painter.js", { type: "module" });
    this.painter.onmessage = ({ data }) => this.#hear(data);
    this.painter.onerror = () => this.#fail("The crane cannot be drawn here.");
    const offscreen = canvas.transferControlToOffscreen();
    this.painter.postMessage({ kind: "start", canvas: offscreen, scene }, [offscreen]);
    this.#follow();
  }

  #follow() {
    new ResizeObserver(() => this.#resize()).observe(this.element);
    document.addEventListener("visibilitychange", () => this.#say({ kind: "visible", visible: !document.hidden }));
    addEventListener("pagehide", () => this.cameras.keep());
    this.station.on("signals", () => this.#signals());
    this.station.on("frame", ({ time, values }) => this.#say({ kind: "frame", time, values }));
    this.station.on("ghost", (detail) => this.#ghost(detail));
    this.station.on("scene", (detail) => this.#change(detail ?? this.home));
    this.#signals();
    this.#resize();
    this.then = performance.now();
    requestAnimationFrame((now) => this.#tick(now));
  }

  #say(message) {
    this.painter.postMessage(message);
  }

  #signals() {
    this.#say({ kind: "signals", names: [...this.station.signals.keys()] });
  }

  #ghost(detail) {
    const ghost = detail && { names: detail.signals.map(([name]) => name), values: detail.values, scene: detail.scene };
    this.#say({ kind: "ghost", ghost });
  }

  #change(scene) {
    this.element.dataset.machine = scene.machine;
    this.cameras.frame(scene);
    this.#say({ kind: "scene", scene });
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    this.cameras.resize(width, height);
    this.#say({ kind: "size", width, height, ratio: Math.min(FINEST, devicePixelRatio) });
  }

  // The camera moves with the screen, and is told only when it has moved.
  #tick(now) {
    const seconds = Math.min(LONGEST_S, (now - this.then) / 1000);
    this.then = now;
    const swing = this.station.value("joint_states/swing.position");
    this.cameras.step(seconds, Number.isFinite(swing) ? swing : 0, this.tip.every(Number.isFinite) ? this.tip : null);
    const pose = this.cameras.pose();
    const told = JSON.stringify(pose, (_, value) => (typeof value === "number" ? Number(value.toFixed(4)) : value));
    if (told !== this.told) this.#say({ kind: "camera", ...pose });
    this.told = told;
    requestAnimationFrame((next) => this.#tick(next));
  }

  #hear(message) {
    if (message.kind === "failed") return this.#fail(message.text);
    this.tip = message.tip;
    this.labels.show(message.labels);
    this.rate.textContent = `${message.rate} pictures/s · ${Math.round(100 * message.share)} %`;
    this.element.dataset.rate = message.rate;
  }

  #fail(text) {
    this.rate.textContent = `The crane cannot be drawn: ${text}`;
    this.element.dataset.failed = text;
  }
}

function overlay(element, name) {
  const added = document.createElement("div");
  added.className = name;
  element.append(added);
  return added;
}
