/** Small pictures on buttons, drawn here so that they look the same everywhere. */

const SVG = 'http://www.w3.org/2000/svg';

/** Outlines on a field of 24 by 24; what ends in ! is filled. */
const SHAPES = {
  play: ['M7 4.5v15l12.5-7.5z!'],
  pause: ['M6.5 5h4v14h-4z!', 'M13.5 5h4v14h-4z!'],
  back: ['M15 6v12l-8-6z!', 'M18.5 6v12'],
  on: ['M9 6v12l8-6z!', 'M5.5 6v12'],
  loop: ['M17.5 7.5A7 7 0 1 0 19 12', 'M18.5 3v5h-5'],
  frame: ['M4 9V4h5', 'M15 4h5v5', 'M20 15v5h-5', 'M9 20H4v-5'],
  follow: ['M12 6a6 6 0 1 0 0.01 0', 'M12 2v5', 'M12 17v5', 'M2 12h5', 'M17 12h5'],
  theme: ['M12 3.5a8.5 8.5 0 1 0 0.01 0', 'M12 3.5a8.5 8.5 0 0 1 0 17z!'],
  picture: ['M12 3v12', 'M7 10.5l5 5 5-5', 'M4 20h16'],
};

/** The picture of a name, to be put into a button. */
export function icon(name) {
  const picture = document.createElementNS(SVG, 'svg');
  picture.setAttribute('viewBox', '0 0 24 24');
  picture.setAttribute('class', 'mg-picture');
  picture.setAttribute('aria-hidden', 'true');
  for (const shape of SHAPES[name]) {
    const path = document.createElementNS(SVG, 'path');
    path.setAttribute('d', shape.replace('!', ''));
    if (shape.endsWith('!')) path.setAttribute('class', 'mg-filled');
    picture.append(path);
  }
  return picture;
}
