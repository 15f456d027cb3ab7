// Where the crane is seen from: cab, side, top, or free. Cab and side turn with the crane.

import { Box3, OrbitControls, PerspectiveCamera, Vector3 } from "../vendor/three.js";

const KEPT = "forest.camera";
const SETTLE_S = 0.22; // time constant of a change of view
const FOLLOW_S = 0.08; // time constant in which the free camera follows a hand
const HEAD_TURN = 0.55; // share of the swing that the operator's head follows
const FREE_FOV = 42; // [deg] until a drag takes over that of another view
const ARRIVED = 0.02; // [m]
const CLEAR = 2.2; // of the reach: from farther away trees stand between, see surroundings.py
const UP = new Vector3(0, 0, 1);

export const VIEWS = ["cab", "side", "top", "free"];

export class Cameras extends EventTarget {
  constructor(element, scene) {
    super();
    this.camera = new PerspectiveCamera(45, 1, 0.2, 300);
    this.camera.up.copy(UP);
    this.target = new Vector3();
    this.controls = new OrbitControls(this.camera, element);
    this.controls.enableDamping = true;
    this.controls.maxPolarAngle = 0.52 * Math.PI;
    this.controls.addEventListener("start", () => this.#take());
    this.controls.addEventListener("change", () => this.dispatchEvent(new Event("view")));
    this.frame(scene);
    const kept = recall();
    this.view = kept.view;
    this.watched = null; // {points, width} of an exercise
    this.following = false; // of the free camera: it keeps the exercise and the tip in the picture
    this.covered = 0; // share of the picture's height that text covers, from above
    this.free = kept.free ?? {
      position: [1.25 * this.reach, -1.0 * this.reach, 0.3 * this.reach], target: [0.25 * this.reach, 0.08 * this.reach, 0],
    };
  }

  // Takes the measures of another scene.
  frame({ work_area, ground }) {
    const [distances, heights] = [0, 1].map((i) => work_area.section.map((point) => point[i]));
    this.reach = Math.max(...distances);
    this.top = Math.max(...heights);
    this.ground = ground;
    this.controls.maxDistance = 6 * this.reach;
    this.controls.minDistance = 0.15 * this.reach;
  }

  // Looks at an exercise's points [m] from above, a little from behind, and follows the tip until somebody drags: what is
  // `width` wide fills a third of the picture, and left is left. null: goes on from where it is.
  watch(points, width = 0) {
    if (!points && this.following) this.#take();
    this.watched = points && { points, width };
    if (points) this.choose("free");
  }

  choose(view) {
    this.keep();
    this.view = view;
    this.following = view === "free" && this.watched !== null;
    this.arriving = view === "free"; // on the way to where the free camera was left
    this.keep();
    this.dispatchEvent(new Event("view"));
  }

  resize(width, height) {
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }

  // Goes to where it belongs at once.
  jump() {
    this.arriving = this.view === "free";
    this.step(100, 0, null);
  }

  // Moves on by some seconds; the crane stands at a swing angle [rad] with its tip somewhere [m].
  step(seconds, swing, tip) {
    if (this.view === "free" && !this.arriving) {
      this.controls.dampingFactor = 1 - Math.exp(-seconds / FOLLOW_S); // by time: pictures may be few
      this.controls.update();
      this.target.copy(this.controls.target);
      return;
    }
    const wanted = this.#wanted(swing, tip);
    const share = 1 - Math.exp(-seconds / SETTLE_S);
    this.camera.position.lerp(wanted.position, share);
    this.target.lerp(wanted.target, share);
    this.camera.fov += share * (wanted.fov - this.camera.fov);
    this.camera.lookAt(this.target);
    const arrived = this.arriving && this.camera.position.distanceTo(wanted.position) < ARRIVED;
    if (arrived && !this.following) this.#take();
  }

  // What the painter needs.
  pose() {
    const { position, quaternion, fov } = this.camera;
    return { position: position.toArray(), quaternion: quaternion.toArray(), fov };
  }

  keep() {
    if (this.view === "free" && !this.arriving) {
      const { position, fov } = this.camera;
      this.free = { position: position.toArray(), target: this.target.toArray(), fov };
    }
    try {
      localStorage.setItem(KEPT, JSON.stringify({ view: this.view, free: this.free }));
    } catch {
      // A browser that keeps nothing still shows the crane.
    }
  }

  #wanted(swing, tip) {
    if (this.view === "cab") return this.#cab(swing, tip);
    if (this.view === "top") return this.#top();
    if (this.view === "side") return this.#side(swing);
    if (this.following) return this.#watching(tip);
    const [position, target] = [this.free.position, this.free.target].map((xyz) => new Vector3(...xyz));
    return { position, target, fov: this.free.fov ?? FREE_FOV };
  }

  // From here on a person's hand moves the camera: a drag in any view begins where that view is.
  #take() {
    if (this.view === "free" && !this.arriving) return;
    this.view = "free";
    this.arriving = this.following = false;
    this.controls.target.copy(this.target);
    this.dispatchEvent(new Event("view"));
  }

  // The exercise and the tip, below what covers the picture.
  #watching(tip) {
    const { points, width } = this.watched;
    const box = [...points, ...(tip ? [tip] : [])].reduce((grown, xyz) => grown.expandByPoint(new Vector3(...xyz)), new Box3());
    const extent = Math.max(3 * width, 1.7 * box.getSize(new Vector3()).length()) / (1 - this.covered);
    const far = this.#far(extent, extent, FREE_FOV);
    const away = new Vector3(-0.45, -0.15, 0.88).normalize();
    const upwards = UP.clone().addScaledVector(away, -away.z).normalize(); // in the picture
    const target = box.getCenter(new Vector3()).addScaledVector(upwards, this.covered * far * Math.tan((FREE_FOV * Math.PI) / 360));
    return { position: target.clone().addScaledVector(away, far), target, fov: FREE_FOV };
  }

  // From the operator's eyes, who looks where the tip is.
  #cab(swing, tip) {
    const scale = -this.ground / 2.2;
    const looked = new Vector3(0.62 * this.reach, 0, -0.1 * this.reach);
    if (tip) looked.lerp(new Vector3(Math.hypot(tip[0], tip[1]), 0, tip[2]), 0.5);
    looked.applyAxisAngle(UP, HEAD_TURN * swing);
    return { position: new Vector3(-1.75 * scale, 0.3 * scale, 0.45 * scale), target: looked, fov: this.#wide(58, 70) };
  }

  // Square to the crane's plane, the carrier and the whole reach in sight; of a narrow picture with a wider eye, before the
  // trees.
  #side(swing) {
    const along = 0.35 * this.reach;
    const [wide, high] = [1.75 * this.reach, 1.2 * (this.top - this.ground)];
    const far = this.#far(wide, high, 36);
    const away = Math.min(far, CLEAR * this.reach);
    const fov = (360 / Math.PI) * Math.atan((far / away) * Math.tan((36 * Math.PI) / 360));
    const [position, target] = [new Vector3(along, -away, 0.12 * this.reach), new Vector3(along, 0, 0.5 * (this.top + this.ground))];
    return { position: position.applyAxisAngle(UP, swing), target: target.applyAxisAngle(UP, swing), fov };
  }

  // From above, forward is up on the screen: a trace of tilt keeps "up" known.
  #top() {
    const high = this.#far(2.15 * this.reach, 2.15 * this.reach, 36);
    return { position: new Vector3(-0.02 * high, 0, high), target: new Vector3(0, 0, 0), fov: 36 };
  }

  // How far away a camera sees a width and a height [m].
  #far(width, height, fov) {
    return Math.max(height, width / this.camera.aspect) / (2 * Math.tan((fov * Math.PI) / 360));
  }

  #wide(landscape, portrait) {
    return this.camera.aspect > 1 ? landscape : portrait;
  }
}

function recall() {
  try {
    const kept = JSON.parse(localStorage.getItem(KEPT));
    if (VIEWS.includes(kept?.view)) return kept;
  } catch {
    // Nothing kept, or nothing that can be read.
  }
  return { view: "side", free: null };
}
