/** The graph: how it is built, its picture, and the transition that was clicked. */

import { element } from '../../dom.js';
import { zoomButtons } from './dock.js';
import { createGraphPicture } from './graph_picture.js';

const STEPS = [50, 100, 200, 400, 800, 1600, 3200, Infinity];
const LEGEND = [
  ['ed-key-kept', 'clip'], ['ed-key-pruned', 'pruned', 'Not in the graph: no way leads back from there'],
  ['ed-key-label', 'label'], ['ed-key-pale', 'never in time', 'In the graph, but no walk gets to its middle within 2 s'],
  ['ed-key-lost', 'lost', 'A label that is not in the graph'],
];

export function createGraph({ ui, side, send, say, dock, onClip }) {
  const seam = ui.panel(side, 'Transition');
  const settings = createSettings({ ui, panel: ui.panel(side, 'Build graph'), send });
  const picture = createGraphPicture(dock.body, {
    onTransition: (edge) => send('transition', { edge }),
    onClip: (name) => onClip(name.replace(/#\d+$/, '')),
    say,
  });
  const state = { clip: null, alone: true };
  const counts = element('span', { class: 'ed-counts', 'data-name': 'counts', title: 'Transitions that are drawn' });
  dock.tools.append(counts);
  const icon = (label, name, title, by) => {
    const made = ui.button(dock.tools, { label, name, title, onClick: () => picture.step(by) });
    made.classList.add('mg-icon');
    made.setAttribute('aria-label', title);
  };
  icon('‹', 'transition-before', 'A nearer transition', -1);
  icon('›', 'transition-after', 'A farther transition', 1);
  zoomButtons(ui, dock.tools, 'graph', picture);
  const legend = createLegend(dock.body);

  const hint = element('p', { class: 'mg-empty', text: 'Click an arc: the transition plays with 0.7 s before and after.' });
  const table = ui.table(seam, 'seam');
  seam.prepend(hint);
  ui.toggle(seam, {
    label: 'Only those of the picked clip', name: 'alone', value: true,
    onChange(value) {
      state.alone = value;
      focus();
    },
  });
  const most = ui.slider(seam, {
    label: 'Nearest transitions shown', name: 'most', min: 0, max: STEPS.length - 1, step: 1, value: 2,
    onInput: (at) => { picture.setMost(STEPS[at]); count(); },
  });
  picture.setMost(STEPS[2]);

  function count() {
    const { shown, all } = picture.counts;
    counts.textContent = all ? `${shown.toLocaleString('en')} of ${all.toLocaleString('en')}` : '';
    legend.set(picture.range);
    most.element.querySelector('output').textContent = shown.toLocaleString('en');
  }

  function focus() {
    picture.setClip(state.alone ? state.clip : null);
    count();
  }

  return {
    panels: [seam.parentElement, settings.panel.parentElement],
    picture,
    setSettings: settings.set,
    working: settings.working,
    shown: focus,
    setClip(name) {
      state.clip = name;
      focus();
    },
    setGraph(note) {
      picture.setGraph(note);
      settings.built(note);
      table.set([]);
      hint.hidden = false;
      focus();
    },
    setSeam({ rows }) {
      hint.hidden = true;
      table.set(rows);
    },
  };
}

function createLegend(parent) {
  const arcs = element('span');
  parent.append(element('p', { class: 'ed-legend' },
    ...LEGEND.map(([look, text, title]) => element('span', { title }, element('i', { class: look }), text)),
    element('span', {}, element('i', { class: 'ed-key-arcs' }), arcs)));
  return {
    set([near, far]) {
      arcs.textContent = `transitions, ${(100 * near).toFixed(1)} … ${(100 * far).toFixed(1)} cm`;
    },
  };
}

/** Threshold, share of the labels, one skeleton for all, and the button. */
function createSettings({ ui, panel, send }) {
  const automatic = ui.toggle(panel, {
    label: 'Automatic threshold', name: 'automatic', title: 'The smallest that keeps the labels', value: true,
    onChange: show,
  });
  const keep = ui.slider(panel, { label: 'Keeps of the labels at least', name: 'keep', unit: '%', min: 0, max: 100, step: 1, value: 90 });
  const threshold = ui.slider(panel, { label: 'Largest distance', name: 'threshold', unit: 'cm', min: 1, max: 30, step: 0.1, value: 5 });
  const retarget = ui.toggle(panel, {
    label: 'Put other skeletons on the first', name: 'retarget', title: 'Needed where clips have different skeletons (--retarget)',
  });
  const build = ui.button(panel, {
    label: 'Build graph', name: 'build', strong: true,
    onClick: () => send('build', {
      threshold_m: automatic.value ? null : threshold.value / 100, keep: keep.value / 100, retarget: retarget.value,
    }),
  });
  const words = ui.sentence(panel, 'built');
  words.set('');
  const notes = element('ul', { class: 'ed-facts', 'data-name': 'notes' });
  panel.append(notes);

  function show() {
    keep.element.hidden = !automatic.value;
    threshold.element.hidden = automatic.value;
  }
  show();

  return {
    panel,
    set({ threshold_m: distance, keep: share, retarget: on }) {
      automatic.value = distance === null;
      if (distance !== null) threshold.value = 100 * distance;
      keep.value = 100 * share;
      retarget.value = on;
      show();
    },
    working({ job, running }) {
      if (job === 'build') build.disabled = running;
    },
    built({ sentence, notes: all }) {
      words.set(`${sentence}.`);
      notes.replaceChildren(...all.slice(0, 20).map((text) => element('li', { text })));
      if (all.length > 20) notes.append(element('li', { text: `… and ${all.length - 20} more` }));
    },
  };
}
