/** Why a throw ended as it did: energies as bars, candidates, what was dropped. */

const EMPTY = 'After a throw: what was chosen from, and what it was worth.';

export function createOutcome(ui, parent) {
  const words = ui.sentence(parent, 'other');
  words.set('');
  const empty = ui.table(parent, 'empty');
  empty.element.textContent = EMPTY;
  const bars = ui.bars(parent, 'energies');
  const table = ui.table(parent, 'figures');

  function fill(rows, items) {
    empty.element.hidden = rows.length > 0;
    table.set(rows);
    bars.set(items);
  }

  return {
    /** What a search or a check of a character says. */
    note({ lane, words: text, tone, rows, bars: items }) {
      if (lane === 1) words.set(`B: ${text}`, tone);
      else if (rows) fill(rows, items);
    },
    /** The notes of a replay: its candidates. */
    show({ notes, bars: items }) {
      words.set('');
      if (notes.length) fill(notes, items);
    },
  };
}
