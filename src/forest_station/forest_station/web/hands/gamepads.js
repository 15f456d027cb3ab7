// Gamepads and joysticks, each with the mapping that this browser keeps for it.

import { DEADMAN, mergeAxes } from "./joy.js";
import { checkedMapping, joystickMapping, mappedAxes, mappedButtons, standardMapping } from "./mapping.js";

const STORED = "forest_station.mapping.";
const hasDeadman = ({ mapping }) => mapping.buttons[DEADMAN] !== null;

export class Gamepads {
  #mappings = new Map(); // by key

  // The connected devices: {key, name, device}. Two of the same make differ by a number.
  connected() {
    const seen = new Map();
    const devices = [...navigator.getGamepads()].filter((device) => device?.connected);
    return devices.map((device) => {
      const count = (seen.get(device.id) ?? 0) + 1;
      seen.set(device.id, count);
      return { key: `${device.id} #${count}`, name: count > 1 ? `${device.id} (${count})` : device.id, device };
    });
  }

  // The mapping of a device: as it was saved, or the usual one.
  mapping({ key, device }) {
    if (!this.#mappings.has(key)) this.#mappings.set(key, this.#stored(key) ?? this.#usual(device));
    return this.#mappings.get(key);
  }

  setMapping(key, mapping) {
    this.#mappings.set(key, mapping);
    localStorage.setItem(STORED + key, JSON.stringify(mapping));
  }

  // Goes back to the usual mapping.
  forgetMapping(key) {
    this.#mappings.delete(key);
    localStorage.removeItem(STORED + key);
  }

  // What devices say together: axes, buttons, for each device that has a deadman whether it is pressed, and the names of
  // those whose axes are away from their centres.
  read(devices = this.connected()) {
    const said = devices.map((one) => {
      const mapping = this.mapping(one);
      return { ...one, mapping, axes: mappedAxes(one.device, mapping), pressed: mappedButtons(one.device, mapping) };
    });
    return {
      axes: mergeAxes(said.map(({ axes }) => axes)),
      pressed: said.reduce((sum, { pressed }) => pressed.map((down, button) => down || Boolean(sum[button])), []),
      deadmen: new Map(said.filter(hasDeadman).map(({ key, pressed }) => [key, pressed[DEADMAN]])),
      aside: said.filter(({ axes }) => axes.some((axis) => axis !== 0)).map(({ name }) => name),
    };
  }

  #stored(key) {
    try {
      return checkedMapping(JSON.parse(localStorage.getItem(STORED + key)));
    } catch {
      return null; // none, or of another version of this page
    }
  }

  // A joystick beside another one is the right hand's.
  #usual(device) {
    if (device.mapping === "standard") return standardMapping();
    const joysticks = this.connected().filter((one) => one.device.mapping !== "standard");
    return joystickMapping(joysticks.findIndex((one) => one.device.index === device.index) === 1);
  }
}
