/** Which balls the graph avoids: the cylinder around the character, unrolled, as a grid of cells. */

import { element } from '../../dom.js';
import { PALETTE } from '../../look.js';
import { between } from './colours.js';

const COMPASS = [[-180, 'behind'], [-90, 'left'], [0, 'ahead'], [90, 'right']];

/** A share as a colour: red is hit, pale half of the balls, blue all avoided. */
function shade(share) {
  return share < 0.5 ? between(PALETTE.red, '#F7F3E3', 2 * share) : between('#F7F3E3', PALETTE.blue, 2 * share - 1);
}

/**
 * @param {HTMLElement} parent
 * @param {{onThrow(direction: number, height: number): void}} calls
 */
export function createCoverageMap(parent, { onThrow }) {
  const empty = element('p', {
    class: 'mg-empty ed-hint', text: 'Throw balls from all around to see which of them the graph avoids.',
  });
  const grid = element('div', { class: 'ed-cover-grid', role: 'group', 'aria-label': 'Coverage', hidden: true });
  const box = element('div', { class: 'ed-cover', 'data-name': 'coverage' }, empty, grid);
  parent.append(box);
  let cells = new Map();

  /** Columns from behind over the left, ahead and the right, as the character sees them. */
  function columnsOf(directions) {
    const right = [...directions].map((degrees) => ((-degrees + 540) % 360) - 180);
    return [...right.keys()].sort((a, b) => right[a] - right[b]).map((n) => ({ n, right: right[n] }));
  }

  function build({ directions, heights, words }) {
    const columns = columnsOf(directions);
    cells = new Map();
    grid.style.gridTemplateColumns = `auto repeat(${columns.length}, minmax(26px, 1fr))`;
    const made = [];
    for (let h = heights.length - 1; h >= 0; h -= 1) {
      made.push(element('span', { class: 'ed-cover-height', text: `${Number(heights[h].toFixed(2))} m` }));
      for (const { n } of columns) {
        const cell = element('button', {
          type: 'button', class: 'ed-cell', 'data-name': `cell-${n}-${h}`,
          on: { click: () => { mark(`${n} ${h}`); onThrow(n, h); }, keydown: (event) => go(event, n, h, columns, heights.length) },
        });
        cell.dataset.from = `${words[n]}, ${Number(heights[h].toFixed(2))} m`;
        cells.set(`${n} ${h}`, cell);
        made.push(cell);
      }
    }
    made.push(element('span'));
    for (const { right } of columns) {
      const name = COMPASS.find(([degrees]) => Math.abs(degrees - right) < 1)?.[1] ?? '';
      made.push(element('span', { class: 'ed-cover-from', text: name }));
    }
    grid.replaceChildren(...made);
  }

  function mark(key) {
    for (const [each, cell] of cells) cell.setAttribute('aria-pressed', String(each === key));
  }

  function go(event, n, h, columns, rows) {
    const at = columns.findIndex((column) => column.n === n);
    const to = {
      ArrowLeft: [(at + columns.length - 1) % columns.length, h], ArrowRight: [(at + 1) % columns.length, h],
      ArrowUp: [at, Math.min(rows - 1, h + 1)], ArrowDown: [at, Math.max(0, h - 1)],
    }[event.key];
    if (!to) return;
    cells.get(`${columns[to[0]].n} ${to[1]}`).focus();
    event.preventDefault();
  }

  return {
    element: box,
    /** What the server found until now; arrays are [directions, heights]. */
    set(map) {
      if (cells.size !== map.directions.length * map.heights.length) build(map);
      empty.hidden = true;
      grid.hidden = false;
      const rows = map.heights.length;
      for (const [key, cell] of cells) {
        const [n, h] = key.split(' ').map(Number);
        const [avoided, hit, none, parried] = [map.avoided, map.hit, map.no_candidate, map.parried].map((array) => array[n * rows + h]);
        const balls = avoided + hit + none + parried;
        const share = balls ? avoided / balls : 0;
        cell.textContent = balls ? Math.round(100 * share) : '–';
        cell.style.background = shade(share);
        cell.style.color = share > 0.8 || share < 0.12 ? '#fff' : '#1d2329';
        cell.title = `From ${cell.dataset.from}: ${avoided} of ${balls} balls avoided, ${hit} hit, ${none} without candidate${parried ? `, ${parried} parried` : ''}. Click to see one.`;
        cell.setAttribute('aria-label', cell.title);
      }
    },
    clear() {
      empty.hidden = false;
      grid.hidden = true;
    },
  };
}
