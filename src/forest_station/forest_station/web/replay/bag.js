// A recorded bag: what the server tells of it, and windows of its frames, fetched before they are due.

const FRAME_HEADER = 16; // [bytes]
export const RATE = 30; // frames a second of the bag's time
const WINDOW_S = 10;
const WINDOW_FRAMES = WINDOW_S * RATE;
const RETRY_MS = 2000;
const MOST_WINDOWS = 12; // kept: two minutes

export class Bag {
  // Opens a bag; `changed` is called when a window has come.
  static async open(name, changed) {
    return new Bag(name, await fetchJson(`${address(name)}.json`), changed);
  }

  constructor(name, told, changed) {
    this.name = name;
    this.seconds = told.seconds;
    this.start = told.start; // [s] of the recorder's clock
    this.signals = told.signals;
    this.events = told.events; // [time, text]
    this.first = told.first; // topic → time of its first message
    this.scene = told.scene;
    this.notes = told.notes;
    this.lastFrame = Math.floor(this.seconds * RATE);
    this.firstFrame = Math.min(this.lastFrame, Math.ceil((told.first.joint_states ?? 0) * RATE)); // in which a crane is seen
    this.trouble = ""; // why a window did not come
    this.columns = new Map(told.signals.map(([signal], column) => [signal, column]));
    this.changed = changed;
    this.windows = new Map(); // number → values of its frames; null while on the way
  }

  // Values of a frame; null while they are on the way, or if the bag has no such frame.
  frame(number) {
    if (number < 0 || number > this.lastFrame) return null;
    const values = this.#window(Math.floor(number / WINDOW_FRAMES));
    if (!values) return null;
    const width = this.signals.length;
    const start = (number % WINDOW_FRAMES) * width;
    return values.subarray(start, start + width);
  }

  // Whether a frame is there already.
  has(number) {
    return Boolean(this.windows.get(Math.floor(number / WINDOW_FRAMES)));
  }

  // Has the windows fetched that are due in `seconds` of the bag's time.
  prepare(number, seconds) {
    const last = Math.min(this.lastFrame, number + seconds * RATE);
    for (let frame = Math.max(0, number); frame <= last; frame += WINDOW_FRAMES) {
      this.#window(Math.floor(frame / WINDOW_FRAMES));
    }
    this.#window(Math.floor(Math.max(0, last) / WINDOW_FRAMES));
  }

  // The value of a signal in a frame [SI]; NaN if it is unknown.
  value(values, signal) {
    return values?.[this.columns.get(signal)] ?? NaN;
  }

  #window(number) {
    const known = this.windows.get(number);
    if (known !== undefined) {
      this.windows.delete(number); // the last used stand last
      this.windows.set(number, known);
      return known;
    }
    this.windows.set(number, null);
    this.#fetch(number);
    while (this.windows.size > MOST_WINDOWS) this.windows.delete(this.windows.keys().next().value);
    return null;
  }

  async #fetch(number) {
    const start = number * WINDOW_S;
    try {
      const query = new URLSearchParams({ start, end: start + WINDOW_S, rate: RATE });
      const response = await fetch(`${address(this.name)}/frames?${query}`);
      if (!response.ok) throw new Error(await response.text());
      const values = valuesOf(await response.arrayBuffer(), this.signals.length);
      if (this.windows.has(number)) this.windows.set(number, values);
      this.trouble = "";
    } catch (error) {
      this.trouble = error.message;
      setTimeout(() => this.windows.delete(number), RETRY_MS); // asked for again when it is wanted again
    }
    this.changed();
  }
}

// The frames' values without their headers.
function valuesOf(data, width) {
  const size = FRAME_HEADER + 4 * width;
  const count = data.byteLength / size;
  const values = new Float32Array(count * width);
  for (let frame = 0; frame < count; frame++) {
    values.set(new Float32Array(data, frame * size + FRAME_HEADER, width), frame * width);
  }
  return values;
}

function address(name) {
  return `/bags/${name.split("/").map(encodeURIComponent).join("/")}`;
}

// What a page of the server says; an error is its sentence.
export async function fetchJson(path) {
  const response = await fetch(path);
  if (!response.ok) throw new Error(await response.text());
  return response.json();
}
