// When charts are drawn: one after the other, for the hands look in between; then all rest, in proportion to the time that
// they took. So a busy page draws them less often, and all that changes meanwhile is painted at once.

const PERIOD_MS = 100; // between two rounds at least
const REST = 4; // of a round's time

const charts = [];

// Has a chart drawn from now on: its `drawNew()` tells whether it had anything to draw.
export function drawn(chart) {
  charts.push(chart);
  if (charts.length === 1) round();
}

async function round() {
  const begun = performance.now();
  for (const chart of [...charts]) if (drew(chart)) await pause(0);
  const took = performance.now() - begun;
  await pause(Math.max(PERIOD_MS - took, REST * took));
  round();
}

// A chart that fails leaves the others alone.
function drew(chart) {
  try {
    return chart.drawNew();
  } catch (error) {
    charts.splice(charts.indexOf(chart), 1);
    reportError(error);
    return false;
  }
}

function pause(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
