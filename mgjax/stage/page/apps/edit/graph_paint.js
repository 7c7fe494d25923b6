/** Draws the picture of a graph: what is in view of it. */

import { BAR, NAMES, rowY } from './arcs.js';
import { kindColour, NEAR_TO_FAR, themed } from './colours.js';
import { markStep } from './spans.js';

const MARGIN = 40;

/**
 * @param {CanvasRenderingContext2D} paper its origin is that of the whole picture
 * @param {object} view `graph` as the server sends it; `shown` transitions with their `curves`; `over`
 *   and `chosen` of them, or null; the `clip` picked, or null; distances from `near` to `far`; `xOf`
 *   frame; `seconds` of the longest clip, `perSecond` pixels; what is in view: `left`, `top`, `wide`,
 *   `high`
 */
export function paintGraph(paper, view) {
  const { graph, top, high } = view;
  const inView = (clip) => rowY(clip) > top - MARGIN && rowY(clip) < top + high + MARGIN;
  graph.clips.forEach((clip, n) => { if (inView(n)) paintClip(paper, view, clip, n); });
  for (const label of graph.labels) if (inView(label.clip)) paintLabel(paper, view, label);
  for (const n of [...view.shown].reverse()) paintArc(paper, view, n);
  for (const n of [view.over, view.chosen]) if (n !== null) paintArc(paper, view, n, true);
  paintNames(paper, view);
  paintRuler(paper, view);
}

function paintClip(paper, { xOf }, { frames, from, to }, n) {
  const y = rowY(n) - BAR / 2;
  paper.fillStyle = themed('--edge');
  paper.fillRect(xOf(0), y, xOf(frames) - xOf(0), BAR);
  paper.save();
  paper.beginPath();
  const parts = to > from ? [[0, from], [to, frames]] : [[0, frames]];
  for (const [a, b] of parts) paper.rect(xOf(a), y, xOf(b) - xOf(a), BAR);
  paper.fillStyle = themed('--plain');
  paper.fill();
  paper.clip();
  paper.beginPath();
  for (let x = xOf(0) - BAR; x < xOf(frames); x += 6) {
    paper.moveTo(x, y + BAR);
    paper.lineTo(x + BAR, y);
  }
  paper.strokeStyle = themed('--quiet');
  paper.lineWidth = 1;
  paper.stroke();
  paper.restore();
  paper.strokeStyle = themed('--edge');
  paper.strokeRect(xOf(0), y, xOf(frames) - xOf(0), BAR);
}

function paintLabel(paper, { xOf }, { clip, start, stop, kind, kept, enterable }) {
  const y = rowY(clip) - BAR / 2;
  const wide = Math.max(2, xOf(stop) - xOf(start));
  paper.fillStyle = kindColour(kind);
  paper.strokeStyle = kindColour(kind);
  if (kept) {
    paper.globalAlpha = enterable ? 1 : 0.4;
    paper.fillRect(xOf(start), y, wide, BAR);
    paper.globalAlpha = 1;
  }
  paper.lineWidth = 1.5;
  paper.strokeRect(xOf(start) + 0.5, y + 0.5, wide - 1, BAR - 1);
}

function colourOf(n, { graph, near, far }) {
  const share = (graph.transitions.distance[n] - near) / Math.max(far - near, 1e-9);
  return NEAR_TO_FAR[Math.min(NEAR_TO_FAR.length - 1, Math.floor(share * NEAR_TO_FAR.length))];
}

function paintArc(paper, view, n, strong = false) {
  const points = view.curves.get(n);
  if (!points) return;
  paper.beginPath();
  paper.moveTo(points[0], points[1]);
  for (let k = 2; k < points.length; k += 2) paper.lineTo(points[k], points[k + 1]);
  paper.globalAlpha = strong ? 1 : Math.max(0.18, Math.min(0.75, 60 / view.shown.length));
  paper.lineWidth = strong ? 3 : 1.1;
  paper.strokeStyle = strong ? themed('--text') : colourOf(n, view);
  paper.stroke();
  if (strong) {
    const last = points.length - 2;
    paper.beginPath();
    paper.arc(points[last], points[last + 1], 4, 0, 7);
    paper.fillStyle = themed('--text');
    paper.fill();
  }
  paper.globalAlpha = 1;
}

/** The names stay at the left while the picture is scrolled. */
function paintNames(paper, { graph, clip, left, top, high }) {
  paper.fillStyle = themed('--plain');
  paper.fillRect(left, top, NAMES - 6, high);
  paper.font = '12px system-ui, sans-serif';
  paper.textBaseline = 'middle';
  paper.textAlign = 'right';
  graph.clips.forEach(({ name }, n) => {
    paper.fillStyle = themed(n === clip ? '--accent' : '--text');
    paper.font = n === clip ? '600 12px system-ui, sans-serif' : '12px system-ui, sans-serif';
    paper.fillText(shortened(paper, name, NAMES - 18), left + NAMES - 12, rowY(n));
  });
}

function paintRuler(paper, { perSecond, seconds, left, top, wide }) {
  paper.fillStyle = themed('--plain');
  paper.fillRect(left, top, wide, 20);
  paper.fillStyle = themed('--quiet');
  paper.font = '11px system-ui, sans-serif';
  paper.textAlign = 'left';
  const step = markStep(perSecond, 58);
  for (let time = 0; time <= seconds; time += step) {
    const x = NAMES + time * perSecond;
    if (x < left + NAMES - 8) continue;
    paper.fillText(`${Number(time.toFixed(1))} s`, x + 3, top + 10);
    paper.fillRect(x, top + 4, 1, 14);
  }
}

function shortened(paper, text, most) {
  if (paper.measureText(text).width <= most) return text;
  let tail = text;
  while (tail.length > 1 && paper.measureText(`…${tail}`).width > most) tail = tail.slice(1);
  return `…${tail}`;
}
