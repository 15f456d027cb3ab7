// A button that acts only as long as it is held.

export function makeHoldButton(label, changed) {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "hold";
  button.dataset.hold = "";
  button.textContent = label;
  let pointer = null;
  const end = (event) => {
    if (pointer !== event.pointerId) return;
    pointer = null;
    changed(false);
  };
  button.addEventListener("pointerdown", (event) => {
    if (pointer !== null || event.button !== 0) return;
    event.preventDefault();
    button.setPointerCapture(event.pointerId);
    pointer = event.pointerId;
    changed(true);
  });
  button.addEventListener("pointermove", (event) => event.buttons === 0 && end(event));
  for (const lost of ["pointerup", "pointercancel", "lostpointercapture"]) button.addEventListener(lost, end);
  return button;
}
