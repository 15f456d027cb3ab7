"""A replay's clock, which waits for its pictures, and its pictures, which keep nothing of the live crane."""

import itertools

from page_stand_in import Js

from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_station.scene.scene_description import scene_of

C180 = load_machine("c180_hoses")

FRAMES_A_SECOND, SPEED = 30, 8
LEAD = 0.5 * SPEED * FRAMES_A_SECOND  # frames by which the clock may be ahead of the picture
SECONDS = 30

# Opens half a minute of a bag, and gives a replay that plays it, and what waits until it stands still.
OPENED = """async (m, [speed, seconds]) => {
  const { Station } = await import("/web/station.js");
  const told = { seconds, start: 0, signals: [["a", "m"]], events: [], first: {}, notes: [], scene: {} };
  const frames = new ArrayBuffer(300 * 20); // of ten seconds
  window.fetch = async (path) => new Response(path.endsWith(".json") ? JSON.stringify(told) : frames);
  const station = new Station();
  station.drawing = true;
  const replay = m.replayOf(station);
  await replay.open("mine");
  replay.setSpeed(speed);
  replay.play(true);
  const standing = async () => {
    for (let seen = NaN, calm = 0; calm < 30; calm = replay.shown === seen ? calm + 1 : 0) {
      seen = replay.shown;
      await new Promise(requestAnimationFrame);
    }
    return replay.shown;
  };
  const draw = () => station.emit("drawn", replay.time);
  const told_at = [await standing(), (draw(), await standing()), (draw(), await standing())];
  station.drawing = false;
  return [told_at, await standing()];
}"""


def test_while_it_plays_the_clock_waits_for_the_pictures_where_there_are_some(js: Js) -> None:
    stops, undrawn = js("replay/replay.js", OPENED, [SPEED, SECONDS])
    assert stops[0] == 0  # nothing of it is seen yet
    for before, after in itertools.pairwise(stops):
        assert LEAD <= after - before < 3 * LEAD  # and one tick of a slow computer
    assert undrawn == SECONDS * FRAMES_A_SECOND


# Draws frames of tips one after another, from above, each an episode of its own if that is wanted; counts the
# pixels of the last picture that are as white as the trail.
PAINTED = """async (_, [scene, names, frames, times, apart]) => {
  const canvas = document.createElement("canvas");
  const [width, height] = [600, 600];
  const painter = new Worker("/web/scene/painter.js", { type: "module" });
  const offscreen = canvas.transferControlToOffscreen();
  painter.postMessage({ kind: "start", canvas: offscreen, scene }, [offscreen]);
  painter.postMessage({ kind: "size", width, height, ratio: 1 });
  painter.postMessage({ kind: "camera", position: [3, 0, 22], quaternion: [0, 0, 0, 1], fov: 36 });
  painter.postMessage({ kind: "signals", names });
  for (const [number, values] of frames.entries()) {
    if (apart) painter.postMessage({ kind: "begin", episode: number });
    const drawn = new Promise((resolve, reject) => {
      painter.onmessage = ({ data }) => {
        if (data.kind === "failed") reject(data.text);
        if (data.time === times[number]) resolve();
      };
    });
    const frame = { kind: "frame", time: times[number], values: Float32Array.from(values) };
    painter.postMessage({ ...frame, live: true });
    await drawn;
  }
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
  context.drawImage(canvas, 0, 0, width, height);
  painter.terminate();
  const { data } = context.getImageData(0, 0, width, height);
  let white = 0;
  for (let i = 0; i < data.length; i += 4) white += Math.min(data[i], data[i + 1], data[i + 2]) > 225;
  return white;
}"""
NAMES = [*(f"tip/pose/{axis}" for axis in "xyz"), *(f"joint_states/{axis}.position" for axis in AXES)]
LINE = 30  # [px] of a trail over some metres, at the least


def test_the_trail_does_not_lead_from_the_live_crane_into_a_recording(js: Js) -> None:
    tips = (start_tip(C180), (4.0, 3.0, 1.0))
    frames = [[*tip, *pose_at(tip, C180)] for tip in tips]
    alone, on, cut, back = (
        js("scene/colours.js", PAINTED, [scene_of(C180), NAMES, seen, times, apart])
        for seen, times, apart in (
            (frames[1:], [0], True),
            (frames, [0, 1], False),
            (frames, [0, 1], True),
            (frames, [1, 0], False),  # a jump to an earlier moment
        )
    )
    assert on > alone + LINE
    assert abs(cut - alone) < LINE / 2
    assert abs(back - alone) < LINE / 2
