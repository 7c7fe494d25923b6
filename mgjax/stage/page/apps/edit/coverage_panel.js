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
      kinds.set(note.kinds.map(([name, value]) => ({ name, value, of: Math.max(...note.kinds.map((k) => k[1])) })));
    },
    clear() {
      map.clear();
      words.set('');
      kinds.set([]);
    },
    working({ running }) { go.disabled = running; },
  };
}
