/** Coverage: how many balls are thrown, and the map of what became of them. */

import { element } from '../../dom.js';
import { createCoverageMap } from './coverage_map.js';

const BALLS_OF_A_ROUND = 288;

export function createCoverage({ ui, side, send, dock }) {
  const map = createCoverageMap(dock.body, { onThrow: (direction, height) => send('throw', { direction, height }) });
  const panel = ui.panel(side, 'Coverage');
  const rounds = ui.slider(panel, {
    label: 'Balls', name: 'rounds', min: 1, max: 10, step: 1, value: 2, onInput: show,
  });
  const go = ui.button(panel, {
    label: 'Throw balls', name: 'cover', strong: true,
    onClick: () => send('cover', { rounds: rounds.value }),
  });
  const words = ui.sentence(panel, 'coverage-words');
  words.set('');
  const heading = element('p', { class: 'mg-label ed-heading', text: 'Avoided by, % of all balls', hidden: true });
  panel.append(heading);
  const kinds = ui.bars(panel, 'coverage-kinds');
  panel.append(element('p', {
    class: 'mg-empty',
    text: 'A cell says how many of the balls from there are avoided, in %: blue all, red none. Click it to see one of them; click again for the next.',
  }));

  function show() {
    rounds.element.querySelector('output').textContent = String(rounds.value * BALLS_OF_A_ROUND);
  }
  show();

  return {
    panels: [panel.parentElement],
    set(note) {
      map.set(note);
      words.set(`${note.sentence}.`);
      heading.hidden = note.kinds.length === 0;
      const most = Math.max(...note.kinds.map(([, share]) => share));
      kinds.set(note.kinds.map(([name, share]) => ({ name: name.replaceAll('_', ' '), value: 100 * share, of: 100 * most })));
    },
    clear() {
      map.clear();
      words.set('');
      heading.hidden = true;
      kinds.set([]);
    },
    working({ running }) { go.disabled = running; },
  };
}
