/** The ways out of a throw beside each other: which one would a person take? */

export function createStudy({ ui, side, link, goLive }) {
  const panel = ui.panel(side, 'Observer study', { open: false });
  const said = ui.sentence(panel, 'study');
  said.set('Compare the ways out of the last throw and pick the one with the least movement.');
  const row = ui.row(panel);
  ui.button(row, { label: 'Compare', onClick: () => link.send({ type: 'compare' }) });
  const save = ui.button(row, { label: 'Save picks', onClick: () => link.send({ type: 'picks' }) });
  save.disabled = true;
  const picks = ui.row(panel);

  return {
    /** Buttons for the candidates of a trial. */
    ask(letters) {
      panel.parentElement.open = true;
      said.set('Which one avoids the ball with the least movement?', 'busy');
      picks.replaceChildren();
      for (const letter of letters) {
        ui.button(picks, {
          label: letter, name: `pick-${letter}`, strong: true,
          onClick: () => link.send({ type: 'pick', letter, observer: 'page' }),
        });
      }
    },
    picked({ agrees, picks: count }) {
      save.disabled = false;
      said.set(`${agrees ? 'So did the search.' : 'The search took another one.'} ${count} picked.`, 'plain');
      picks.replaceChildren();
      goLive();
    },
    hide: () => picks.replaceChildren(),
  };
}
