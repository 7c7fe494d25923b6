/** What is written over the picture: names and notes, the axes in the corner, handles of a thing. */

import { armOf } from './camera.js';
import { handlesOf } from './gizmo.js';
import { PALETTE } from './look.js';
import { clamp, cross, dot, normalize } from './math.js';

const FONT = '13px system-ui, sans-serif';
const HIGH = 22;
const MARGIN = 6;
const GAP = 2;
const AXIS_COLOURS = { x: PALETTE.red, y: PALETTE.green, z: PALETTE.blue };

/**
 * Draws over a picture.
 * @param {CanvasRenderingContext2D} paper in pixels of the page
 * @param {object} view camera, theme, labels of content.js `labelsOf`, taken: boxes of the page that
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
  const placed = [];
  for (const label of labels) {
    const at = camera.project(label.place);
    if (!at) continue;
    const [x, y] = at;
    if (x < -20 || x > camera.width + 20 || y < -20 || y > camera.height + 20) continue;
    const box = boxFor(paper, camera, label, x, y);
    settle(box, taken, camera);
    taken.push(box);
    placed.push([label, box, at]);
  }
  for (const each of placed) drawPointer(paper, ...each);
  for (const [label, box] of placed) drawLabel(paper, theme, label, box);
}

function boxFor(paper, camera, { text, place, aside }, x, y) {
  const wide = Math.min(camera.width - 2 * MARGIN, paper.measureText(text).width + 16);
  const beside = aside === undefined ? null : x + camera.pixelsAt(place) * aside + 8;
  const wanted = beside === null ? [x - wide / 2, y - HIGH - 4] : [beside, y - HIGH / 2];
  const left = clamp(wanted[0], MARGIN, camera.width - MARGIN - wide);
  const top = clamp(wanted[1], MARGIN, camera.height - MARGIN - HIGH);
  const moved = Math.hypot(left - wanted[0], top - wanted[1]);
  return { left, top, wide, high: HIGH, moved };
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
  if (!best) return;
  box.moved += Math.hypot(best.left - box.left, best.top - box.top);
  Object.assign(box, best);
}

/** A line from a label that had to move to what it names. */
function drawPointer(paper, { colour }, { left, top, wide, moved }, [x, y]) {
  if (moved <= 6) return;
  paper.strokeStyle = PALETTE[colour] ?? PALETTE.grey;
  paper.lineWidth = 1;
  paper.beginPath();
  paper.moveTo(clamp(x, left + 8, left + wide - 8), clamp(y, top, top + HIGH));
  paper.lineTo(x, y);
  paper.stroke();
}

function drawLabel(paper, theme, { text, colour }, { left, top, wide }) {
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
