/** The clips: a picture of each, what is known of it, its labels, and whether it is in the graph. */

import { element } from '../../dom.js';
import { kindColour } from './colours.js';
import { drawFilmstrip } from './filmstrip.js';

const MOST_DOTS = 12;

/**
 * A list that is filled while clips are read.
 * @param {HTMLElement} parent
 * @param {{onPick(name: string): void, onUse(name: string, on: boolean): void}} calls
 */
export function createClipList(parent, { onPick, onUse }) {
  const rows = new Map();
  const known = new Map();
  const filter = element('input', {
    type: 'search', class: 'ed-filter', placeholder: 'Find a clip', 'aria-label': 'Find a clip',
    'data-name': 'filter', on: { input: () => sift() },
  });
  const list = element('div', { class: 'ed-clips', 'data-name': 'clips', role: 'list' });
  const none = element('p', { class: 'mg-empty', text: 'No clip is called so.', hidden: true });
  parent.append(filter, list, none);
  const seen = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) if (isIntersecting) draw(target);
  }, { root: list, rootMargin: '100px' });

  function draw(canvas) {
    const entry = known.get(canvas.dataset.clip);
    if (!entry?.strip || !canvas.clientWidth) return;
    drawFilmstrip(canvas, entry.strip, entry.parents);
    seen.unobserve(canvas);
  }

  function makeRow(name) {
    const picture = element('canvas', { class: 'ed-strip', 'data-clip': name, 'aria-hidden': 'true' });
    const detail = element('span', { class: 'mg-entry-detail', text: 'waits to be read' });
    const dots = element('span', { class: 'ed-dots' });
    const use = element('input', {
      type: 'checkbox', checked: true, title: 'In the graph when it is built next',
      'aria-label': `${name} in the graph`, 'data-name': `use-${name}`,
      on: { change: () => onUse(name, use.checked) },
    });
    const pick = element('button', {
      type: 'button', class: 'mg-entry ed-clip', 'data-name': `clip-${name}`, title: name,
      on: { click: () => onPick(name) },
    }, picture, element('span', { class: 'mg-entry-label', text: name }), detail, dots);
    const row = element('div', { class: 'ed-row', role: 'listitem' }, pick, use);
    rows.set(name, { row, pick, picture, detail, dots, use });
    return row;
  }

  function sift() {
    const wanted = filter.value.trim().toLowerCase();
    let found = 0;
    for (const [name, { row }] of rows) {
      row.hidden = !name.toLowerCase().includes(wanted);
      found += row.hidden ? 0 : 1;
    }
    none.hidden = found > 0;
    list.scrollTop = 0;
  }

  return {
    element: list,
    setNames(names) {
      seen.disconnect();
      rows.clear();
      known.clear();
      list.replaceChildren(...names.map(makeRow));
      filter.hidden = names.length < 8;
    },
    /** What was read: `{name, lines, error, frames, rate, parents, strip}`. */
    setEntry(entry) {
      const row = rows.get(entry.name);
      if (!row) return;
      known.set(entry.name, entry);
      const bad = Boolean(entry.error);
      row.pick.classList.toggle('ed-bad', bad);
      row.picture.hidden = bad;
      row.use.disabled = bad;
      row.detail.textContent = bad ? entry.error : summary(entry);
      row.pick.title = [entry.name, ...(bad ? [entry.error] : entry.lines)].join('\n');
      if (!bad) seen.observe(row.picture);
    },
    setLabels(name, labels) {
      const row = rows.get(name);
      if (!row) return;
      row.dots.replaceChildren(...labels.slice(0, MOST_DOTS).map(({ kind }) => {
        const dot = element('i', { title: kind });
        dot.style.background = kindColour(kind);
        return dot;
      }), labels.length > MOST_DOTS ? `+${labels.length - MOST_DOTS}` : '');
    },
    setLeftOut(names) {
      for (const [name, { use, row }] of rows) {
        use.checked = !names.has(name);
        row.classList.toggle('ed-unused', names.has(name));
      }
    },
    set picked(name) {
      for (const [each, { pick }] of rows) pick.setAttribute('aria-pressed', String(each === name));
      rows.get(name)?.row.scrollIntoView({ block: 'nearest' });
    },
    /** Pictures in the colours of the page as they are now. */
    redraw() {
      for (const [name, { picture }] of rows) if (known.get(name)?.strip) seen.observe(picture);
    },
  };
}

function summary({ frames, rate, lines, problem }) {
  const seconds = `${(frames / rate).toFixed(1)} s`;
  const odd = lines.length > 1 ? ` · ${lines.length - 1} ${lines.length > 2 ? 'oddities' : 'oddity'}` : '';
  return problem ? `${seconds} · labels do not fit` : seconds + odd;
}
