/** What is written over the picture: names and notes, the axes in the corner, handles of a thing. */

import { armOf } from './camera.js';
import { handlesOf } from './gizmo.js';
import { PALETTE } from './look.js';
import { cross, dot, normalize } from './math.js';

const FONT = '13px system-ui, sans-serif';
const HIGH = 22;
const MARGIN = 6;
const GAP = 2;
const AXIS_COLOURS = { x: PALETTE.red, y: PALETTE.green, z: PALETTE.blue };

/**
 * Draws over a picture.
 * @param {CanvasRenderingContext2D} paper in pixels of the page
 * @param {object} view camera, theme, labels [{text, place, colour}], taken: boxes of the page that
 *   labels keep clear of, [{left, top, wide, high}], handles: a thing or null, held: the axis
 *   under the pointer
 */
export function drawOverlay(paper, { camera, theme, labels, taken = [], handles, held }) {
  paper.font = FONT;
  paper.textBaseline = 'middle';
  paper.textAlign = 'center';
  if (handles) drawHandles(paper, camera, handles, held);
  drawLabels(paper, camera, theme, labels, [...taken, { left: 0, top: camera.height - 70, wide: 70, high: 70 }]);
  drawAxes(paper, camera, theme);
}

function drawLabels(paper, camera, theme, labels, taken) {
  for (const label of labels) {
    const at = camera.project(label.place);
    if (!at) continue;
    const [x, y] = at;
    if (x < -20 || x > camera.width + 20 || y < -20 || y > camera.height + 20) continue;
    const box = boxFor(paper, camera, label.text, x, y);
    settle(box, taken, camera);
    taken.push(box);
    drawLabel(paper, theme, label, box, at);
  }
}

function boxFor(paper, camera, text, x, y) {
  const most = camera.width - 2 * MARGIN;
  const wide = Math.min(most, paper.measureText(text).width + 16);
  const left = Math.min(camera.width - MARGIN - wide, Math.max(MARGIN, x - wide / 2));
  const top = Math.min(camera.height - MARGIN - HIGH, Math.max(MARGIN, y - HIGH - 4));
  return { left, top, wide, high: HIGH };
}

/** Moves a box to the nearest place where it covers no other; rather aside or up than down. */
function settle(box, taken, camera) {
  const meets = ({ left, top }) => taken.some((other) => (
    top < other.top + other.high + GAP && other.top < top + HIGH + GAP
    && left < other.left + other.wide + GAP && other.left < left + box.wide + GAP));
  const inside = ({ left, top }) => left >= MARGIN && left + box.wide <= camera.width - MARGIN
    && top >= MARGIN && top <= camera.height - MARGIN - HIGH;
  const cost = ({ left, top }) => Math.abs(left - box.left) * 1.5
    + (top > box.top ? 4 * (top - box.top) : box.top - top);
  const lefts = [box.left, ...taken.flatMap(({ left, wide }) => (
    [left - box.wide - GAP, left + wide + GAP]))];
  const tops = [box.top, ...taken.flatMap(({ top, high }) => [top - HIGH - GAP, top + high + GAP])];
  let best = null;
  for (const left of lefts) {
    for (const top of tops) {
      const place = { left, top };
      if ((!best || cost(place) < cost(best)) && inside(place) && !meets(place)) best = place;
    }
  }
  Object.assign(box, best);
}

function drawLabel(paper, theme, { text, colour }, { left, top, wide }, [x, y]) {
  const middle = Math.min(left + wide - 8, Math.max(left + 8, x));
  if (Math.abs(top + HIGH + 4 - y) > 6 || middle !== x) {
    paper.strokeStyle = theme.edge;
    paper.lineWidth = 1;
    paper.beginPath();
    paper.moveTo(middle, y < top ? top : top + HIGH);
    paper.lineTo(x, y);
    paper.stroke();
  }
  paper.beginPath();
  paper.roundRect(left, top, wide, HIGH, 6);
  paper.fillStyle = theme.plate;
  paper.fill();
  paper.strokeStyle = theme.edge;
  paper.lineWidth = 1;
  paper.stroke();
  paper.fillStyle = PALETTE[colour] ?? PALETTE.grey;
  paper.fillRect(left + 6, top + HIGH - 4, wide - 12, 2);
  paper.fillStyle = theme.text;
  paper.fillText(text, left + wide / 2, top + HIGH / 2, wide - 12);
}

function drawAxes(paper, camera, theme) {
  const arm = armOf(camera);
  const right = normalize(cross([0, 1, 0], arm));
  const up = cross(arm, right);
  const [x, y, size] = [34, camera.height - 34, 20];
  const axes = [['x', [1, 0, 0]], ['y', [0, 1, 0]], ['z', [0, 0, 1]]];
  axes.sort((a, b) => dot(a[1], arm) - dot(b[1], arm));
  paper.lineCap = 'round';
  for (const [name, way] of axes) {
    const [dx, dy] = [dot(way, right), -dot(way, up)];
    paper.strokeStyle = AXIS_COLOURS[name];
    paper.lineWidth = 2.5;
    paper.beginPath();
    paper.moveTo(x, y);
    paper.lineTo(x + dx * size, y + dy * size);
    paper.stroke();
    paper.fillStyle = theme.text;
    paper.font = '11px system-ui, sans-serif';
    paper.fillText(name.toUpperCase(), x + dx * (size + 8), y + dy * (size + 8));
  }
  paper.font = FONT;
}

function drawHandles(paper, camera, thing, held) {
  paper.lineCap = 'round';
  for (const { axis, from, to } of handlesOf(thing, camera)) {
    const [a, b] = [camera.project(from), camera.project(to)];
    if (!a || !b) continue;
    const angle = Math.atan2(b[1] - a[1], b[0] - a[0]);
    paper.strokeStyle = paper.fillStyle = AXIS_COLOURS[axis];
    paper.lineWidth = held === axis ? 5 : 3;
    paper.beginPath();
    paper.moveTo(a[0], a[1]);
    paper.lineTo(b[0], b[1]);
    paper.stroke();
    paper.beginPath();
    for (const [along, across] of [[10, 0], [-3, 7], [-3, -7]]) {
      paper.lineTo(b[0] + along * Math.cos(angle) - across * Math.sin(angle),
        b[1] + along * Math.sin(angle) + across * Math.cos(angle));
    }
    paper.fill();
  }
}
