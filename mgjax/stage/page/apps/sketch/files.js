/** Files of `mgjax walk`, saved and opened; the motion and the picture. */

const MOST = 1_900_000;

/** @returns {{enable(walked: boolean)}} */
export function createFiles({ ui, side, link, stage }) {
  const body = ui.panel(side, 'Files');
  const rows = [ui.row(body), ui.row(body)];
  const save = (label, what) => ui.button(rows[0], {
    label, name: `save-${what}`, title: `As mgjax walk reads it (${what}.json)`,
    onClick: () => link.send({ type: 'save', what }),
  });
  const saved = [save('Save path', 'path'), save('Save targets', 'targets')];
  ui.fileButton(rows[0], {
    label: 'Open …', name: 'open', accept: '.json,.csv,.txt', onText(text, name) {
      if (text.length > MOST) {
        link.replay({ type: 'sentence', text: `${name}: got a file of more than 1.9 MB, expected a path or targets`, tone: 'bad' });
        return;
      }
      link.send({ type: 'open', name: name.slice(-100), text });
    },
  });
  const bvh = ui.button(rows[1], {
    label: 'Motion (BVH)', name: 'export-bvh', onClick: () => link.send({ type: 'export', what: 'bvh' }),
  });
  ui.button(rows[1], {
    label: 'Picture (PNG)', name: 'export-png', onClick() {
      const [, data] = stage.snapshot()?.split(',') ?? [];
      if (data) ui.download('sketch.png', Uint8Array.from(atob(data), (c) => c.charCodeAt(0)), 'image/png');
    },
  });
  return {
    enable(walked) {
      bvh.disabled = !walked;
      saved[0].disabled = !walked;
    },
  };
}
