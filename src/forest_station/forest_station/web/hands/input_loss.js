// Everything in a browser after which nobody knows whether a hand is still where it was.

// Calls `release(why)` for each of them.
export function watchInputLoss(release) {
  const on = (target, event, why, when = () => true) =>
    target.addEventListener(event, (details) => when(details) && release(why), true);
  on(window, "blur", "the window lost the focus", ({ target }) => target === window); // not a button, for another one
  on(window, "pagehide", "the page was left");
  on(document, "visibilitychange", "the page was hidden");
  on(document, "freeze", "the browser froze the page");
  on(document, "fullscreenchange", "the page went to full screen or back");
  on(window, "pointercancel", "the browser took the pointer away");
  on(window, "touchcancel", "the browser took the touch away");
  on(window, "contextmenu", "a context menu opened", (event) => !isLongPress(event));
  on(window, "dragstart", "something was dragged");
}

// A finger that rests on a stick asks for a context menu, too; it gets none, and nothing is lost.
function isLongPress(event) {
  if (event.pointerType !== "touch" || !event.target.closest?.("[data-hold]")) return false;
  event.preventDefault();
  return true;
}
