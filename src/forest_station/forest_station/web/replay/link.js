// The link to a moment: `#bag=NAME&t=12.34&with=OTHER&offset=0.5`.

// The moment that a link names, {name, time, over, offset}; null if it names none.
export function momentOf(hash) {
  const words = new URLSearchParams(hash.replace(/^#/, ""));
  const name = words.get("bag");
  if (!name) return null;
  return { name, time: number(words.get("t")), over: words.get("with") ?? "", offset: number(words.get("offset")) };
}

export function linkTo({ name, time, over, offset }) {
  const words = new URLSearchParams({ bag: name, t: time.toFixed(2) });
  if (over) words.set("with", over);
  if (over && offset) words.set("offset", Number(offset.toFixed(3)));
  return `#${words}`.replaceAll("%2F", "/");
}

function number(text) {
  const value = Number(text);
  return Number.isFinite(value) ? value : 0;
}
