// The crane in three dimensions.

export async function drawScene(element, station, scene) {
  element.dataset.machine = scene.machine;
}
