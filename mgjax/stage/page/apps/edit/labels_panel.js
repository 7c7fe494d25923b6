/** Labels: the timeline, the form of the chosen one, undo, and the file. */

import { element, freshId } from '../../dom.js';
import { zoomButtons } from './dock.js';
import { createTimeline } from './timeline.js';

const LONGEST_KIND = 40;

export function createLabels({ stage, player, ui, side, send, say, dock }) {
  const state = { clip: null, labels: {}, kind: 'duck', changed: false, file: null, playing: null };
  const timeline = createTimeline(dock.body, {
    onAdd: (span) => send('label_add', { clip: state.clip.name, kind: state.kind, ...span }),
    onMove: (label, span) => send('label_change', { clip: state.clip.name, label, ...span }),
    onDelete: (label) => send('label_delete', { clip: state.clip.name, label }),
    onChoose: () => form.show(timeline.chosen),
    onSeek(time) {
      if (state.playing !== state.clip?.name) send('pick', { clip: state.clip.name });
      player.pause();
      player.seek(time);
    },
    say,
  });
  const tools = createTools({ ui, dock, send, timeline, save });
  const panel = ui.panel(side, 'Label');
  const form = createForm({ ui, panel, send, state, clip: () => state.clip, remove: deleteChosen });
  const clash = createClash({ ui, panel, send });
  stage.onFrame(() => timeline.at(state.playing === state.clip?.name ? stage.time : 0, player.playing));

  function save() {
    send('save');
  }

  function deleteChosen() {
    const { chosen } = timeline;
    if (chosen) send('label_delete', { clip: state.clip.name, label: chosen.id });
    return Boolean(chosen);
  }

  return {
    panels: [panel.parentElement],
    save,
    deleteChosen,
    conflict: () => clash.show(),
    shown: () => timeline.fit(),
    /** The clip that plays in the picture above, or null: something else does. */
    set playing(name) {
      state.playing = name;
      timeline.element.dataset.playing = name ?? '';
    },
    setFile({ labels_file: name }) {
      state.file = name;
      tools.file(name);
    },
    /** The clip whose labels are shown; `{name}` alone while it has not been read. */
    setClip(entry) {
      if (state.clip && entry && state.clip.name === entry.name) return;
      state.clip = entry && !entry.error ? entry : null;
      timeline.setClip(state.clip);
      if (state.clip) timeline.setLabels(state.labels[state.clip.name] ?? []);
      form.show(null);
    },
    setLabels(note) {
      state.labels = note.all ? { ...note.clips } : { ...state.labels, ...note.clips };
      state.changed = note.changed;
      form.setChoices(note);
      tools.set(note);
      if (!note.changed) clash.hide();
      if (state.clip && (note.all || Object.hasOwn(note.clips, state.clip.name))) {
        timeline.setLabels(state.labels[state.clip.name] ?? []);
      }
    },
    choose(clip, label) {
      if (state.clip?.name === clip) timeline.choose(label);
    },
  };
}

/** Undo, redo, save, and what is not saved, beside the tabs. */
function createTools({ ui, dock, send, timeline, save }) {
  const undo = ui.button(dock.tools, { label: '↶', name: 'undo', title: 'Undo (Ctrl Z)', onClick: () => send('undo') });
  const redo = ui.button(dock.tools, { label: '↷', name: 'redo', title: 'Redo (Ctrl Y)', onClick: () => send('redo') });
  for (const [made, title] of [[undo, 'Undo'], [redo, 'Redo']]) {
    made.classList.add('mg-icon');
    made.setAttribute('aria-label', title);
  }
  const keep = ui.button(dock.tools, { label: 'Save', name: 'save', title: 'Save (S)', onClick: save });
  const unsaved = element('span', { class: 'ed-unsaved', role: 'status', 'data-name': 'unsaved' });
  dock.tools.append(unsaved);
  zoomButtons(ui, dock.tools, 'timeline', timeline);
  addEventListener('beforeunload', (event) => {
    if (unsaved.dataset.changed === 'true' && keep.dataset.file === '') event.preventDefault();
  });
  return {
    file(name) {
      keep.textContent = name ? 'Save' : 'Download';
      keep.title = name ? `Save ${name} (S)` : 'These clips are in no folder: the labels are downloaded (S)';
      keep.dataset.file = name ?? '';
    },
    set({ changed, can_undo: canUndo, can_redo: canRedo }) {
      undo.disabled = !canUndo;
      redo.disabled = !canRedo;
      keep.disabled = !changed && keep.dataset.file !== '';
      keep.classList.toggle('mg-strong', changed);
      unsaved.textContent = changed ? 'not saved yet' : '';
      unsaved.dataset.changed = String(changed);
    },
  };
}

/** Kind, direction and genuine of the chosen label, and its seconds. */
function createForm({ ui, panel, send, state, clip, remove }) {
  let label = null;
  const hint = element('p', {
    class: 'mg-empty', text: 'Drag on the empty timeline to make a label; click one to change it. Arrows move it by a frame.',
  });
  const kinds = element('datalist', { id: freshId() });
  const kind = element('input', {
    type: 'text', class: 'ed-text', id: freshId(), maxLength: LONGEST_KIND, 'data-name': 'kind', 'list': kinds.id,
    autocomplete: 'off',
    on: {
      change() {
        state.kind = kind.value.trim() || state.kind;
        change({ kind: kind.value });
      },
      keydown(event) { if (event.key === 'Enter') kind.blur(); },
    },
  });
  const whole = element('div', { class: 'ed-form' });
  panel.append(hint, whole);
  whole.append(element('div', { class: 'mg-choice' },
    element('label', { class: 'mg-label', for: kind.id, text: 'Kind' }), kind, kinds));
  const places = element('div');
  whole.append(places);
  let direction = null;
  let known = '';
  const genuine = ui.toggle(whole, {
    label: 'A real evasion (solid; else dashed)', name: 'genuine', title: 'Off: an exercise that resembles one',
    onChange: (value) => change({ genuine: value }),
  });
  const when = element('p', { class: 'ed-when', 'data-name': 'label-seconds' });
  whole.append(when);
  ui.button(whole, { label: 'Delete label', name: 'delete-label', title: 'Delete', onClick: remove });

  function change(what) {
    if (label) send('label_change', { clip: clip().name, label: label.id, ...what });
  }

  const form = {
    setChoices({ kinds: all, directions }) {
      kinds.replaceChildren(...all.map((value) => element('option', { value })));
      if (known === directions.join('\n')) return;
      known = directions.join('\n');
      places.replaceChildren();
      direction = ui.choice(places, {
        label: 'Direction, as the character sees it', name: 'direction', value: label?.direction ?? '',
        options: directions.map((value) => ({ value, label: value || 'none' })),
        onChange: (value) => change({ direction: value }),
      });
    },
    show(next) {
      label = next;
      hint.hidden = Boolean(next);
      whole.hidden = !next;
      if (!next) return;
      if (document.activeElement !== kind) kind.value = next.kind;
      state.kind = next.kind;
      if (direction) direction.value = next.direction;
      genuine.value = next.genuine;
      when.textContent = `${next.start_s.toFixed(3)} … ${next.end_s.toFixed(3)} s, frames ${next.start} … ${next.stop - 1}`;
    },
  };
  form.show(null);
  return form;
}

/** What can be done where somebody else wrote the file. */
function createClash({ ui, panel, send }) {
  const box = element('div', { class: 'ed-clash', hidden: true, 'data-name': 'clash' });
  panel.prepend(box);
  const say = ui.sentence(box, 'clash-words');
  const buttons = ui.row(box);
  ui.button(buttons, { label: 'Overwrite it', name: 'overwrite', onClick: () => { clash.hide(); send('save', { overwrite: true }); } });
  ui.button(buttons, { label: 'Read it again', name: 'reread', onClick: () => { clash.hide(); send('reread'); } });
  const clash = {
    show() {
      box.hidden = false;
      say.set('The labels file was changed on disk. Overwrite it with what is here, or read it again and lose what is not saved?', 'bad');
    },
    hide() { box.hidden = true; },
  };
  return clash;
}
