/** The flat canvas over the stage's own, on which is written, and both as one picture. */

/** A canvas over another one that takes no part in clicks: its context. */
export function makePaper(canvas) {
  const sheet = document.createElement('canvas');
  sheet.className = 'mg-paper';
  sheet.setAttribute('aria-hidden', 'true');
  canvas.after(sheet);
  return sheet.getContext('2d');
}

/** Makes the sheet as large as the page shows it, empties it, and counts in pixels of the page. */
export function clearPaper(paper, wide, high) {
  const ratio = Math.min(2, globalThis.devicePixelRatio || 1);
  const [width, height] = [Math.round(wide * ratio), Math.round(high * ratio)];
  if (paper.canvas.width !== width || paper.canvas.height !== height) {
    Object.assign(paper.canvas, { width, height });
  }
  paper.setTransform(1, 0, 0, 1, 0, 0);
  paper.clearRect(0, 0, width, height);
  paper.setTransform(ratio, 0, 0, ratio, 0, 0);
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
