// A worker: has the page look at its hands. A browser holds back a page's own timers for 0.1 s after a touch; what a
// worker says it hears. The page itself looks and tells: one that hangs says nothing.

const PERIOD_MS = 20;

setInterval(() => postMessage(null), PERIOD_MS);
