/** The flat canvas over the stage's own, on which is written, and both as one picture. */

import { drawOverlay } from './overlay.js';

/** A canvas over another one that takes no part in clicks. */
export function createPaper(canvas) {
  const sheet = document.createElement('canvas');
  sheet.className = 'mg-paper';
  sheet.setAttribute('aria-hidden', 'true');
  canvas.after(sheet);
  const paper = sheet.getContext('2d');
  let written = '';
  return {
    canvas: sheet,
    /** Writes what is to be read on a picture (overlay.js), unless it stands there already. */
    write(view) {
      const { width, height } = view.camera;
      const ratio = Math.min(2, globalThis.devicePixelRatio || 1);
      const text = JSON.stringify([width, height, ratio, contentOf(view)]);
      if (text === written) return;
      written = text;
      const [wide, high] = [width, height].map((side) => Math.round(side * ratio));
      if (sheet.width !== wide || sheet.height !== high) Object.assign(sheet, { width: wide, height: high });
      paper.setTransform(1, 0, 0, 1, 0, 0);
      paper.clearRect(0, 0, wide, high);
      paper.setTransform(ratio, 0, 0, ratio, 0, 0);
      drawOverlay(paper, view);
    },
    remove: () => sheet.remove(),
  };
}

/** All that the writing hangs on; where labels are, to a tenth of a pixel. */
function contentOf({ camera, theme, labels, taken, handles, held }) {
  const tenths = (place) => camera.project(place)?.map((value) => Math.round(10 * value));
  return [
    camera.yaw, camera.pitch, theme.text, taken, held, handles && [handles, camera.toClip],
    labels.map(({ text, colour, place, aside }) => (
      [text, colour, tenths(place), aside && Math.round(10 * aside * camera.pixelsAt(place))])),
  ];
}

/** Two canvases, one over the other, as a PNG in a data URL. */
export function asPicture(below, above) {
  const whole = document.createElement('canvas');
  Object.assign(whole, { width: below.width, height: below.height });
  const paper = whole.getContext('2d');
  paper.drawImage(below, 0, 0);
  paper.drawImage(above, 0, 0, below.width, below.height);
  return whole.toDataURL('image/png');
}

/** Where elements lie over a canvas, in its pixels of the page: [{left, top, wide, high}]. */
export function boxesOver(canvas, elements) {
  if (!elements.length) return [];
  const own = canvas.getBoundingClientRect();
  return elements.map((each) => {
    const { left, top, width, height } = each.getBoundingClientRect();
    return { left: left - own.left, top: top - own.top, wide: width, high: height };
  });
}
