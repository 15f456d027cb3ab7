// Gamepads and joysticks: what each of their axes and buttons does; calibrated, saved in this browser, exchanged as JSON.

import { make, makeButton, setText } from "../elements.js";
import { Calibration } from "../hands/calibration.js";
import { handsOf } from "../hands/hands.js";
import { AXES, BUTTONS, DEADMAN } from "../hands/joy.js";
import { checkedMapping, newEntry } from "../hands/mapping.js";

export const place = "left";
export const title = "Gamepads and joysticks";

const PERIOD_MS = 100;
const DOES = ["tip left, right", "tip away, back", "(right stick, sideways)", "tip up, down", "(left trigger)", "(right trigger)"];

export function mount(element, station) {
  const { gamepads } = handsOf(station);
  const none = make("p", {}, "None is connected. Plug one in and press a button on it.");
  const list = make("div");
  element.append(none, list);
  const views = new Map(); // by key
  setInterval(() => {
    const connected = gamepads.connected();
    none.hidden = connected.length > 0;
    for (const [key, view] of views) {
      if (connected.some((one) => one.key === key)) continue;
      view.element.remove();
      views.delete(key);
    }
    for (const one of connected) {
      if (!views.has(one.key)) views.set(one.key, new Device(gamepads, one));
      const view = views.get(one.key);
      if (!view.element.isConnected) list.append(view.element);
      view.look(one);
    }
  }, PERIOD_MS);
}

// One device's mapping, as a form.
class Device {
  constructor(gamepads, one) {
    this.gamepads = gamepads;
    this.one = one;
    this.calibration = null;
    this.element = make("details", { className: "device" });
    this.state = make("p");
    this.state.setAttribute("role", "status");
    this.build();
  }

  get mapping() {
    return this.gamepads.mapping(this.one);
  }

  save(mapping, text = "Saved in this browser.") {
    this.gamepads.setMapping(this.one.key, mapping);
    this.build();
    setText(this.state, text);
  }

  build() {
    this.meters = AXES.map(() => make("meter", { min: -1, max: 1, low: -1, high: 1 }));
    const rows = AXES.map((_, axis) => this.#row(axis));
    const head = make("tr", {}, ...["does", "from", "invert", "deadzone", ""].map((text) => make("th", {}, text)));
    this.element.replaceChildren(
      make("summary", {}, this.one.name),
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows)),
      this.#deadman(),
      make("div", { className: "buttons" }, ...this.#buttons()),
      this.state,
    );
  }

  // Shows what the device says, and lets a calibration see it.
  look(one) {
    this.one = one;
    this.calibration?.look(one.device);
    const axes = this.gamepads.read([one]).axes;
    this.meters.forEach((meter, axis) => (meter.value = axes[axis]));
  }

  #row(axis) {
    const entry = this.mapping.axes[axis];
    const name = AXES[axis];
    const from = this.#choice(`${name}: from`, ["", ...this.#parts()], entry?.from ?? "", (value) =>
      this.#setAxis(axis, value && { ...(entry ?? newEntry(value)), from: value }),
    );
    const invert = make("input", { type: "checkbox", checked: entry?.invert ?? false, disabled: !entry });
    invert.setAttribute("aria-label", `${name}: invert`);
    invert.onchange = () => this.#setAxis(axis, { ...entry, invert: invert.checked });
    const deadzone = make("input", { type: "number", min: 0, max: 0.5, step: 0.01, disabled: !entry });
    deadzone.value = entry?.deadzone ?? "";
    deadzone.setAttribute("aria-label", `${name}: deadzone`);
    deadzone.onchange = () => this.#setAxis(axis, { ...entry, deadzone: deadzone.valueAsNumber });
    const inverted = make("label", {}, invert, " invert");
    deadzone.title = "deadzone";
    return make("tr", {}, ...[DOES[axis], from, inverted, deadzone, this.meters[axis]].map((part) => make("td", {}, part)));
  }

  #parts() {
    const { axes, buttons } = this.one.device;
    return [...axes.map((_, number) => `axis ${number}`), ...buttons.map((_, number) => `button ${number}`)];
  }

  #deadman() {
    const numbers = this.one.device.buttons.map((_, number) => String(number));
    const now = String(this.mapping.buttons[DEADMAN] ?? "");
    const choice = this.#choice("deadman button", ["", ...numbers], now, (value) => {
      const buttons = this.mapping.buttons.map((number, button) => (button === DEADMAN ? null : number));
      buttons[DEADMAN] = value === "" ? null : Number(value);
      this.save({ ...this.mapping, buttons });
    });
    return make("label", {}, `Deadman (${BUTTONS[DEADMAN].replace("_", " ")}): button `, choice);
  }

  #buttons() {
    const file = make("input", { type: "file", accept: ".json,application/json", hidden: true });
    file.onchange = () => this.#import(file);
    return [
      makeButton(this.calibration ? "Done" : "Calibrate", () => this.#calibrate()),
      makeButton("As usual", () => this.#forget()),
      makeButton("Export", () => this.#export()),
      makeButton("Import", () => file.click()),
      file,
    ];
  }

  #choice(label, values, value, chosen) {
    const select = make("select", {}, ...values.map((text) => new Option(text || "none", text, false, text === value)));
    select.setAttribute("aria-label", label);
    select.onchange = () => chosen(select.value);
    return select;
  }

  #setAxis(axis, entry) {
    const axes = [...this.mapping.axes];
    axes[axis] = entry || null;
    try {
      this.save(checkedMapping({ ...this.mapping, axes }));
    } catch (error) {
      this.build();
      setText(this.state, error.message);
    }
  }

  #calibrate() {
    if (this.calibration) {
      const mapping = this.calibration.finish();
      this.calibration = null;
      this.save(mapping, "Calibrated, and saved in this browser.");
      return;
    }
    this.calibration = new Calibration(this.one.device, this.mapping);
    this.build();
    setText(this.state, "Its centre is taken. Now move every axis to both ends, let go, and press Done.");
  }

  #forget() {
    this.calibration = null;
    this.gamepads.forgetMapping(this.one.key);
    this.build();
    setText(this.state, "The usual mapping of such a device.");
  }

  #export() {
    const text = JSON.stringify({ device: this.one.device.id, ...this.mapping }, null, 2);
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "application/json" })) });
    link.download = "gamepad.json";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async #import(file) {
    try {
      this.save(checkedMapping(JSON.parse(await file.files[0].text())), "Imported, and saved in this browser.");
    } catch (error) {
      setText(this.state, `Not imported: ${error.message}`);
    }
    file.value = "";
  }
}
