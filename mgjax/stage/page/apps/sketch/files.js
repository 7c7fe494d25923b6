/** Files of `mgjax walk`, saved and opened. */

const MOST = 1_900_000;

/** @returns {{enable(walked: boolean, reached: boolean)}} */
export function createFiles({ ui, side, link }) {
  const body = ui.panel(side, 'Files');
  const row = ui.row(body);
  const save = (label, what) => ui.button(row, {
    label, name: `save-${what}`, title: `As mgjax walk reads it (${what}.json)`,
    onClick: () => link.send({ type: 'save', what }),
  });
  const saved = [save('Save path', 'path'), save('Save targets', 'targets')];
  ui.fileButton(row, {
    label: 'Open …', name: 'open', accept: '.json,.csv,.txt', onText(text, name) {
      if (text.length > MOST) {
        link.replay({ type: 'sentence', text: `${name}: got a file of more than 1.9 MB, expected a path or targets`, tone: 'bad' });
        return;
      }
      link.send({ type: 'open', name: name.slice(-100), text });
    },
  });
  return {
    enable(walked, reached) {
      saved[0].disabled = !walked;
      saved[1].disabled = !reached;
    },
  };
}
