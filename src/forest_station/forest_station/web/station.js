// The link to the server, and the newest minute of every signal. The protocol: docs/reference/station-protocol.md.

import { History } from "./history.js";

const FRAME_HEADER = 16; // [bytes]
const RETRY_MS = 500;
const MOST_WAITING = 480; // [bytes] ten hands messages: 0.2 s of them
const ANSWER_MS = 5000; // a service of the graph may take some seconds

// Emits "frame" (a Frame: {time, values}), "signals" when they change, each kind of message of the protocol, "open" and
// "close" with the server's reason, if it told one.
export class Station extends EventTarget {
  constructor() {
    super();
    this.signals = new Map(); // name → column
    this.units = [];
    this.history = new History(0);
    this.scene = null; // of the live crane, once it is known
    this.live = true; // false: a replay shows its frames through `show`
    this.drawing = false; // whether pictures are drawn: "drawn" tells the time of the frame in each
    this.socket = null;
    this.requests = new Map(); // number → resolve
    this.requestNumber = 0;
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/socket`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.emit("open");
    this.socket.onmessage = ({ data }) => (typeof data === "string" ? this.#hear(JSON.parse(data)) : this.#frame(data));
    this.socket.onclose = ({ reason }) => {
      for (const resolve of this.requests.values()) resolve({ ok: false, text: "The connection to the crane is lost." });
      this.requests.clear();
      this.emit("close", reason);
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  get connected() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  // Calls `listener(detail)` for each event of a kind.
  on(kind, listener) {
    this.addEventListener(kind, (event) => listener(event.detail));
  }

  emit(kind, detail) {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }

  // The newest value of a signal [SI]; NaN if it is unknown.
  value(name) {
    return this.history.newest(this.signals.get(name));
  }

  // Sends a request; resolves to its answer {ok, text}, also where none comes.
  ask(what, args = {}) {
    if (!this.connected) return Promise.resolve({ ok: false, text: "There is no connection to the crane." });
    const number = ++this.requestNumber;
    this.socket.send(JSON.stringify({ do: what, number, ...args }));
    return new Promise((resolve) => {
      this.requests.set(number, resolve);
      setTimeout(() => resolve({ ok: false, text: "The server has not answered yet." }), ANSWER_MS);
    });
  }

  // Sends the bytes of a hands message; false if nobody can hear them in time: what waits behind others counts for nothing.
  sendHands(bytes) {
    if (!this.connected || this.socket.bufferedAmount > MOST_WAITING) return false;
    this.socket.send(bytes);
    return true;
  }

  // Shows a frame of the crane or, while `live` is false, of a replay.
  show(frame) {
    this.history.push(frame);
    this.emit("frame", frame);
  }

  setSignals(signals) {
    this.signals = new Map(signals.map(([name], column) => [name, column]));
    this.units = signals.map(([, unit]) => unit);
    this.history = new History(signals.length);
    this.emit("signals", signals);
  }

  #hear(message) {
    if (message.kind === "welcome") this.setSignals(message.signals);
    if (message.kind === "answer") {
      this.requests.get(message.to)?.(message);
      this.requests.delete(message.to);
    }
    this.emit(message.kind, message);
  }

  #frame(data) {
    if (!this.live) return;
    this.show({ time: new DataView(data).getFloat64(8, true), values: new Float32Array(data, FRAME_HEADER) });
  }
}
