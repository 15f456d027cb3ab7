// Every colour of the scene, once.

export const COLOURS = {
  sky: 0x0d1318,
  horizon: 0x2a3640,
  ground: 0x1d252b,
  grid: 0x33414b,
  gridFine: 0x27323a,
  beam: 0xe6a92e,
  cast: 0x49545d,
  barrel: 0x2f3840,
  rod: 0xdfe7ee,
  head: 0x5d6973,
  log: 0x9a7350,
  bark: 0x6b4f38,
  hose: 0x0b0e11,
  flowOut: 0xff9d3c, // oil to the actuator
  flowBack: 0x4aa8ff, // oil from the actuator
  wish: 0x3fd0ff,
  tip: 0xf6f8fa,
  area: 0x58d68d,
  wall: 0xff8a5c,
  alarm: 0xff3b30,
  ghost: 0xa78bfa,
  shadow: 0x11171b,
  paint: 0x3d4a3f,
  steel: 0x5a666f,
  glass: 0x88b6cc,
  rubber: 0x15191c,
  tree: 0x1c3327,
  trunk: 0x2c241d,
  exercise: 0xffe14d,
  taught: 0xf77fbe,
};
