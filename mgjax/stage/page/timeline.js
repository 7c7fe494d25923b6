/** The timeline of a player: the slider, moments above it, rows of spans below. */

import { clock, element } from './dom.js';
import { PALETTE } from './look.js';

/**
 * Fills `lanes` with a timeline.
 * @param {HTMLElement} lanes
 * @param {HTMLInputElement} scrub the slider, kept
 * @param {{begin?: number, seconds?: number, spans?: object[], moments?: [string, number][]}} show
 * @param {(time: number) => void} seek
 * @returns {{at(time: number): void}} moves the head
 */
export function drawTimeline(lanes, scrub, { begin = 0, seconds = 0, spans = [], moments = [] }, seek) {
  const whole = seconds - begin;
  const share = (time) => (whole > 0 ? Math.min(1, Math.max(0, (time - begin) / whole)) : 0);
  const head = element('div', { class: 'mg-head' });
  const rows = [...new Set(spans.map(({ row }) => row))];
  const track = element('div', { class: 'mg-track' });
  if (moments.length) track.append(momentLane(moments, share, seek));
  track.append(scrub);
  for (const row of rows) {
    track.append(spanLane(row, spans.filter((span) => span.row === row), share, seek));
  }
  track.append(head);
  const names = element('div', { class: 'mg-names', 'aria-hidden': 'true' },
    ...(moments.length ? [element('span', { text: '' })] : []), element('span', { text: '' }),
    ...rows.map((row) => element('span', { text: row, title: row })));
  track.addEventListener('pointerdown', (event) => {
    if (event.target === scrub || event.target.closest('.mg-moment')) return;
    const box = track.getBoundingClientRect();
    seek(((event.clientX - box.left) / Math.max(1, box.width)) * whole + begin);
  });
  lanes.classList.toggle('mg-named', rows.length > 0);
  lanes.replaceChildren(names, track);
  return { at: (time) => { head.style.left = `${100 * share(time)}%`; } };
}

function momentLane(moments, share, seek) {
  const lane = element('div', { class: 'mg-lane mg-moments' });
  for (const [text, time] of moments) {
    const mark = element('button', {
      type: 'button', class: 'mg-moment', text, title: `${text}, ${clock(time)}`,
      'data-name': 'moment', on: { click: () => seek(time) },
    });
    mark.style.left = `${100 * share(time)}%`;
    if (share(time) > 0.7) mark.dataset.side = 'left';
    lane.append(mark);
  }
  return lane;
}

function spanLane(row, spans, share) {
  const lane = element('div', { class: 'mg-lane', 'data-row': row });
  for (const { start, end, text, colour = 'grey' } of spans) {
    const span = element('div', { class: 'mg-span', title: `${text}: ${clock(start)} – ${clock(end)}` },
      element('span', { text }));
    span.style.left = `${100 * share(start)}%`;
    span.style.width = `max(2px, ${100 * (share(end) - share(start))}%)`;
    span.style.setProperty('--hue', PALETTE[colour] ?? PALETTE.grey);
    lane.append(span);
  }
  return lane;
}
