/** Sketch: a path drawn on the floor is walked, and hands and head reach on the way. */

import { savePanel } from '../save.js';
import { createChosen } from './sketch/chosen.js';
import { createFiles } from './sketch/files.js';
import { createPen } from './sketch/pen.js';
import { createPicture } from './sketch/picture.js';
import { createTools } from './sketch/tools.js';

const READY_MADE = {
  line: 'Line', s_curve: 'S', circle: 'Circle', square: 'Square', eight: 'Eight', reaches: 'With reaches',
};
const STAND_BACK = 3;
const LOOK_DOWN = 0.46;
const EMPTY = 'Draw on the floor where to walk, or take a ready-made path.';

export function start({ stage, player, ui, side, link, options }) {
  player.live = false;
  const picture = createPicture({ stage, player });

  const main = ui.panel(side, 'Sketch');
  const said = ui.sentence(main, 'outcome');
  said.set(EMPTY, 'plain');
  const ready = ui.row(main);
  for (const name of options.ready_made) {
    ui.button(ready, {
      label: READY_MADE[name] ?? name, name: `ready-${name.replace('_', '-')}`,
      title: 'A ready-made path', onClick: () => link.send({ type: 'ready_made', name }),
    });
  }
  const tools = createTools({ ui, side, onTool: (tool) => { stage.tool = tool === 'draw' ? 'draw' : 'look'; } });
  const chosen = createChosen({ ui, side, link });
  const figures = ui.table(ui.panel(side, 'Figures'), 'figures');

  const path = ui.panel(side, 'Path');
  const smooth = ui.toggle(path, {
    label: 'Smooth', title: 'A curve through what was drawn, else its corners', value: true,
    onChange: (on) => link.send({ type: 'smooth', on }),
  });
  const closed = ui.toggle(path, {
    label: 'Closed', title: 'The path leads back to where it begins',
    onChange: (on) => link.send({ type: 'closed', on }),
  });
  const method = ui.choice(path, {
    label: 'Search', value: 'exact',
    options: [{ value: 'exact', label: 'Exact' }, { value: 'beam', label: 'Beam' }],
    onChange: (name) => link.send({ type: 'method', name }),
  });
  const edit = ui.row(tools.body);
  const undo = ui.button(edit, { label: 'Undo', title: 'Ctrl+Z', onClick: () => link.send({ type: 'undo' }) });
  const clear = ui.button(edit, { label: 'Clear', onClick: () => link.send({ type: 'clear' }) });
  const files = createFiles({ ui, side, link });
  savePanel({ stage, player, ui, side, link, formats: options.formats });
  for (const each of [undo, clear]) each.disabled = true;
  files.enable(false, false);

  const pen = createPen(stage, (points) => {
    said.set('Looking for a walk …', 'busy');
    link.send({ type: 'path', points });
  });

  stage.onThingDrag(({ id, phase, place, end }) => {
    chosen.pick(id.split('.')[0]);
    if (phase === 'start') return;
    const done = phase === 'end';
    link.send({ type: 'move', id, place, ...(end ? { end } : {}), done, ...(done ? {} : { latest: true }) });
  });
  stage.onClick(({ floor, thing }) => {
    if (thing !== null) chosen.pick(thing.split('.')[0]);
    else if (tools.places && floor) link.send({ type: 'add', kind: tools.tool, place: [...floor] });
    else chosen.pick(null);
  });
  tools.pick('draw');
  roomToDraw(stage);

  link.on('note', (note) => {
    if (note.event !== 'drawn') return;
    pen.lift();
    picture.show(note);
    const goesOn = note.better && !note.dragged;
    const more = goesOn ? ' Looking for a better walk …' : '';
    said.set(note.words + more, goesOn && note.tone === 'good' ? 'busy' : note.tone);
    figures.set(note.figures);
    chosen.set(note.items);
    smooth.value = note.smooth;
    closed.value = note.closed;
    method.value = note.method;
    clear.disabled = !note.items.length && !note.lines.length;
    undo.disabled = note.undo === 0;
    files.enable(note.lines.length > 0, note.items.some(({ kind }) => kind !== 'obstacle'));
    if (goesOn) requestAnimationFrame(() => link.send({ type: 'refine', version: note.version, latest: true }));
  });
  link.on('sentence', ({ text, tone }) => {
    pen.lift();
    said.set(text, tone);
  });

  document.addEventListener('keydown', (event) => {
    if (event.target.matches('input:not([type=range]), select, textarea')) return;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z') link.send({ type: 'undo' });
    else if (['Delete', 'Backspace'].includes(event.key) && chosen.id) link.send({ type: 'remove', id: chosen.id });
    else return;
    event.preventDefault();
  });
}

/** The camera stands back, so that there is floor to draw on. */
function roomToDraw(stage) {
  const stop = stage.onFrame(() => {
    stop();
    stage.frameAll();
    stage.camera.pitch = LOOK_DOWN;
    stage.camera.zoom(STAND_BACK);
    stage.wake();
  });
  stage.wake();
}
