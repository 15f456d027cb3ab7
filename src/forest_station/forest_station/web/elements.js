// Builds elements: `make("button", { className: "big", onclick: act }, "text", child)`.

export function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

// Sets a text, if it differs: what a screen reader reads aloud must not be set again and again.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// A button that says what it does.
export function makeButton(text, onclick, className = "") {
  return make("button", { type: "button", textContent: text, onclick, className });
}

// Calls `paint` before the next redraw, once, however often the returned function is called.
export function oncePerRedraw(paint) {
  let waiting = false;
  return () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      paint();
    });
  };
}
