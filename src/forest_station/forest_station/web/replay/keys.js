// Keys of a replay. The space bar and Escape stay the emergency stop's: the live crane goes on.

import { isTyping } from "../hands/keyboard.js";
import { SPEEDS } from "./replay.js";

const JUMP_S = 5;

const KEYS = {
  k: (replay) => replay.play(!replay.playing),
  j: (replay) => replay.seek(replay.time - JUMP_S),
  l: (replay) => replay.seek(replay.time + JUMP_S),
  ",": (replay) => replay.step(-1),
  ".": (replay) => replay.step(1),
  "-": (replay) => replay.setSpeed(SPEEDS[Math.max(0, SPEEDS.indexOf(replay.speed) - 1)]),
  "+": (replay) => replay.setSpeed(SPEEDS[Math.min(SPEEDS.length - 1, SPEEDS.indexOf(replay.speed) + 1)]),
};

export const KEYS_TEXT = "K plays and pauses, J and L jump 5 s, comma and full stop step, − and + set the speed";

export function listenToKeys(replay) {
  addEventListener("keydown", (event) => {
    const act = KEYS[event.key.toLowerCase()];
    const others = event.ctrlKey || event.altKey || event.metaKey;
    if (!act || others || !replay.active || isTyping(event)) return;
    event.preventDefault();
    act(replay);
  });
}
