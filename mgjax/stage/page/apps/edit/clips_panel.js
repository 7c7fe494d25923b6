/** The panel of the clips: the list, and what there is to say of the one that is picked. */

import { element } from '../../dom.js';
import { createClipList } from './clip_list.js';

export function createClips({ ui, side, send, onPick }) {
  const panel = ui.panel(side, 'Clips');
  const reading = ui.progress(panel, 'reading');
  const list = createClipList(panel, { onPick, onUse: (clip, on) => send('use', { clip, on }) });
  const first = element('summary', { 'data-name': 'info' });
  const facts = element('ul', { class: 'ed-facts', 'data-name': 'facts' });
  const more = element('details', { class: 'ed-more', hidden: true }, first, facts);
  panel.append(more);
  const entries = new Map();
  const state = { names: [], picked: null };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => list.redraw());
  new MutationObserver(() => list.redraw()).observe(document.documentElement, { attributeFilter: ['data-theme'] });

  function say() {
    const entry = entries.get(state.picked);
    const lines = entry ? (entry.error ? [entry.error] : entry.lines) : [];
    more.hidden = !lines.length;
    first.textContent = lines[0] ?? '';
    facts.replaceChildren(...lines.slice(1).map((text) => element('li', { text })));
    if (entry?.problem) {
      facts.append(element('li', { class: 'ed-bad', text: entry.problem }));
      more.open = true;
    }
  }

  return {
    panel: panel.parentElement,
    setNames({ names, strange, labels_file: file }) {
      state.names = names;
      list.setNames(names);
      reading.set(0, `reading ${names.length} clips`);
      if (strange.length) {
        const shown = strange.slice(0, 3).join(', ') + (strange.length > 3 ? ', …' : '');
        panel.append(element('p', {
          class: 'mg-empty', text: `${file} also names clips that are not here: ${shown}. What it says of them stays.`,
        }));
      }
    },
    setRows(rows) {
      for (const row of rows) {
        entries.set(row.name, row);
        list.setEntry(row);
      }
      const { size } = entries;
      reading.set(size / Math.max(1, state.names.length), `${size} of ${state.names.length} clips are read`);
      say();
    },
    setLabels({ clips, all }) {
      for (const name of all ? state.names : Object.keys(clips)) list.setLabels(name, clips[name] ?? []);
    },
    setLeftOut: (names) => list.setLeftOut(names),
    entry: (name) => entries.get(name),
    get picked() { return state.picked; },
    set picked(name) {
      state.picked = name;
      list.picked = name;
      say();
    },
  };
}
