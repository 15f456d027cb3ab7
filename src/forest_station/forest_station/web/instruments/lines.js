// What the lines of an instrument are, computed from the newest minute of their signals.
//
// A line has `label`, `signals`: names, and one of
//   value(...values): one number at a time, from the signals' values then [SI];
//   minute(times, ...columns): all numbers of the minute at once, as for a sum over time.

// The values of a line at every frame of the minute; NaN where one of its signals is unknown.
export function lineValues(line, times, columns) {
  if (line.minute) return line.minute(times, ...columns);
  return times.map((_, i) => line.value(...columns.map((column) => column[i])));
}

// The integral of a rate over time, from the first frame on. A gap adds nothing.
export function integral(times, rates) {
  let sum = 0;
  return Array.from(times, (time, i) => {
    const step = i === 0 ? 0 : ((rates[i] + rates[i - 1]) / 2) * (time - times[i - 1]);
    sum += Number.isFinite(step) ? step : 0;
    return sum;
  });
}

// How far a point is from where its commanded velocity would have taken it within the last `window` seconds.
//
// NaN until a whole window is known. Columns: three of the position, three of the commanded velocity.
export function pathError(window, times, ...columns) {
  const positions = columns.slice(0, 3);
  const wanted = columns.slice(3).map((rates) => integral(times, rates));
  let [first, unknown] = [0, -1];
  return Array.from(times, (time, i) => {
    if (columns.some((column) => !Number.isFinite(column[i]))) unknown = i;
    while (times[first + 1] <= time - window) first++;
    if (unknown >= first || times[first] > time - window) return NaN;
    return Math.hypot(...positions.map((at, axis) => at[i] - at[first] - (wanted[axis][i] - wanted[axis][first])));
  });
}
