// A worker: draws the scene on its own thread. Where pixels are drawn by the processor a picture takes longer than
// a heartbeat of the deadman; the page's own thread never waits for it.
//
// Hears: start, size, camera, scene, begin, signals, frame, ghost, exercise, taught, trouble, visible. Says: drawn, failed.

import { ColorManagement, LinearSRGBColorSpace, PerspectiveCamera, Vector3, WebGLRenderer } from "../vendor/three.js";
import { Picture } from "./picture.js";
import { Resolution, drawsBySoftware } from "./resolution.js";
import { Signals } from "./signals.js";

ColorManagement.enabled = false; // colours as written: no power function for each pixel

const state = {
  renderer: null, picture: null, signals: new Signals(), ghost: null, exercise: null, taught: null, trouble: "", visible: true, waiting: false, failed: false,
  before: null, // a picture that was replaced: its programs serve the new one until that is drawn
  episode: 0, // of frames that belong together: of the live crane, or of a replay
  begun: false, // whether a frame of it has come
};
const camera = new PerspectiveCamera(45, 1, 0.2, 300);
const software = drawsBySoftware();
const resolution = new Resolution(software);
const size = { width: 1, height: 1, ratio: 1, fresh: true };

const hear = {
  start({ canvas, scene }) {
    // By the processor, smooth edges cost as much as twice the resolution, which shows more.
    state.renderer = new WebGLRenderer({ canvas, antialias: !software });
    state.renderer.outputColorSpace = LinearSRGBColorSpace;
    state.picture = new Picture(scene);
  },
  size(message) {
    Object.assign(size, message, { fresh: true });
  },
  camera({ position, quaternion, fov }) {
    camera.position.set(...position);
    camera.quaternion.set(...quaternion);
    camera.fov = fov;
    camera.updateProjectionMatrix();
  },
  scene({ scene }) {
    state.before?.dispose();
    state.before = state.picture;
    state.picture = new Picture(scene);
    state.picture.showGhost(state.ghost);
    state.picture.exercise.show(state.exercise);
    state.picture.taught.show(state.taught);
    state.picture.limits.trouble = state.trouble;
  },
  begin({ episode }) {
    Object.assign(state, { episode, begun: false });
    state.picture.trail.clear();
  },
  signals({ names }) {
    state.signals = new Signals(names);
  },
  frame({ time, values, live }) {
    state.begun = true;
    state.picture.limits.live = live;
    state.signals.show(time, values);
    state.picture.push(state.signals);
  },
  ghost({ names, values, scene }) {
    state.ghost = names ? { scene: scene ?? state.ghost?.scene, signals: new Signals(names) } : null;
    state.ghost?.signals.show(NaN, values);
    state.picture.showGhost(state.ghost);
  },
  exercise({ exercise }) {
    state.exercise = exercise;
    state.picture.exercise.show(exercise);
  },
  taught({ taught }) {
    state.taught = taught;
    state.picture.taught.show(taught);
  },
  trouble({ trouble }) {
    state.trouble = state.picture.limits.trouble = trouble;
  },
  visible({ visible }) {
    state.visible = visible;
  },
};

self.onmessage = ({ data }) => {
  if (state.failed) return;
  try {
    hear[data.kind](data);
    drawSoon();
  } catch (error) {
    state.failed = true;
    self.postMessage({ kind: "failed", text: error.message });
  }
};

// Takes a new size, or another resolution. It empties the canvas, so a picture follows at once.
function resize() {
  size.fresh = false;
  state.renderer.setPixelRatio(size.ratio * resolution.share);
  state.renderer.setSize(size.width, size.height, false);
  camera.aspect = size.width / size.height;
  camera.updateProjectionMatrix();
}

// Draws once, however many messages came: the newest counts.
function drawSoon() {
  if (state.waiting || !state.visible || !state.renderer) return;
  state.waiting = true;
  self.setTimeout(() => self.requestAnimationFrame(draw), resolution.rest());
}

function draw() {
  state.waiting = false;
  if (!state.visible) return;
  if (size.fresh) resize();
  const began = performance.now();
  const labels = state.picture.pose(state.signals);
  state.renderer.render(state.picture.root, camera);
  finish(state.renderer.getContext());
  state.before?.dispose();
  state.before = null;
  size.fresh ||= resolution.drawn(began, performance.now());
  self.postMessage({
    kind: "drawn", labels: labels.map(onScreen), tip: state.picture.tip().toArray(), rate: resolution.rate, share: resolution.share,
    episode: state.begun ? state.episode : NaN, time: state.signals.time,
  });
}

// Waits until the picture is there: else nobody knows how long it took.
function finish(gl) {
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

// A label with its place on the screen [px] instead of in space.
function onScreen({ key, text, at, kind }) {
  const seen = new Vector3().copy(at).project(camera);
  const ahead = seen.z < 1;
  return { key, text, kind, x: 0.5 * (seen.x + 1) * size.width, y: 0.5 * (1 - seen.y) * size.height, ahead };
}
