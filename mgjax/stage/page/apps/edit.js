/** Edit: clips, the labels on them, the graph made of them, and the balls that it avoids. */

import { element } from '../dom.js';
import { savePanel } from '../save.js';
import { createClips } from './edit/clips_panel.js';
import { createCoverage } from './edit/coverage_panel.js';
import { createDock } from './edit/dock.js';
import { createGraph } from './edit/graph_panel.js';
import { createLabels } from './edit/labels_panel.js';

const HINT = 'Pick a clip: it plays, and its labels can be dragged in the timeline.';

export function start({ stage, player, ui, side, link }) {
  document.head.append(element('link', { rel: 'stylesheet', href: new URL('./edit/edit.css', import.meta.url).href }));
  player.live = false;
  const said = ui.sentence(side, 'said');
  said.set(HINT);
  const work = createWork(ui, side, link);
  const say = (text, tone = 'plain') => said.set(text, tone);
  const send = (type, what = {}) => link.send({ type, ...what });
  const dock = createDock(player.element.parentElement, ['Labels', 'Graph', 'Coverage'], (tab) => show(tab));
  const shared = { stage, player, ui, side, send, say };
  const clips = createClips({ ...shared, onPick: pick });
  const labels = createLabels({ ...shared, dock: dock.part('Labels') });
  const graph = createGraph({ ...shared, dock: dock.part('Graph'), onClip: pick });
  const coverage = createCoverage({ ...shared, dock: dock.part('Coverage') });
  savePanel({ stage, player, ui, side, link, formats: [] });
  const tabs = { Labels: labels, Graph: graph, Coverage: coverage };
  // Beside graph and coverage the list of clips is folded, unless the person wants it.
  const unfolded = { Labels: true, Graph: false, Coverage: false };
  let open = 'Labels';
  clips.panel.addEventListener('toggle', () => { unfolded[open] = clips.panel.open; });

  function show(tab) {
    for (const [name, { panels }] of Object.entries(tabs)) {
      for (const panel of panels) panel.hidden = name !== tab;
    }
    open = tab;
    clips.panel.open = unfolded[tab];
    tabs[tab].shown?.();
  }

  function pick(name) {
    clips.picked = name;
    labels.setClip(clips.entry(name));
    graph.setClip(name);
    if (clips.entry(name)?.error) say(clips.entry(name).error, 'bad');
    else send('pick', { clip: name });
  }

  const notes = {
    clips(note) {
      clips.setNames(note);
      labels.setFile(note);
      graph.setSettings(note.settings);
    },
    rows({ rows }) {
      clips.setRows(rows);
      if (!clips.picked && rows.some(({ error }) => !error)) {
        pick(rows.find(({ error }) => !error).name);
      } else if (rows.some(({ name }) => name === clips.picked)) labels.setClip(clips.entry(clips.picked));
    },
    labels(note) {
      clips.setLabels(note);
      labels.setLabels(note);
    },
    used: ({ left_out: names }) => clips.setLeftOut(new Set(names)),
    chosen: ({ clip, label }) => labels.choose(clip, label),
    went({ clip }) {
      if (clip !== clips.picked) pick(clip);
    },
    conflict: () => labels.conflict(),
    graph(note) {
      graph.setGraph(note);
      coverage.clear();
    },
    map: (note) => coverage.set(note),
    job(note) {
      work.set(note);
      graph.working(note);
      coverage.working(note);
    },
    seam: (note) => graph.setSeam(note),
  };
  link.on('note', (note) => notes[note.event]?.(note));
  link.on('sentence', ({ text, tone }) => say(text, tone));
  link.on('show', (message) => {
    stage.follow = null;
    stage.frameAll();
    labels.playing = message.of === 'clip' ? message.clip : null;
    player.play();
    if (message.of === 'clip') say(`${message.clip} plays.`);
    if (message.of === 'transition') say(`${message.show.words}.`);
  });
  hearKeys(labels, send);
  if (globalThis.mgjax) globalThis.mgjax.graph = graph.picture;
  dock.open('Labels');
}

/** What goes on in the background, with a bar and a button that stops it. */
function createWork(ui, side, link) {
  const box = element('div', { class: 'ed-work', hidden: true });
  side.append(box);
  const bar = ui.progress(box, 'work');
  let job = null;
  ui.button(box, { label: 'Stop', name: 'stop', onClick: () => job && link.send({ type: 'stop', job }) });
  return {
    set({ job: name, share, text, running }) {
      job = running ? name : null;
      box.hidden = !running;
      bar.set(Math.min(share, 0.999), text);
    },
  };
}

/** Keys that count everywhere on the page, unless a text is being written. */
function hearKeys(labels, send) {
  document.addEventListener('keydown', (event) => {
    const { tagName, type } = event.target;
    const writing = tagName === 'TEXTAREA' || (tagName === 'INPUT' && ['text', 'search'].includes(type));
    if (event.defaultPrevented || writing || tagName === 'SELECT') return;
    const key = event.key.toLowerCase();
    const command = event.ctrlKey || event.metaKey;
    if (command && key === 'z') send(event.shiftKey ? 'redo' : 'undo');
    else if (command && key === 'y') send('redo');
    else if (key === 's' && !event.altKey) labels.save();
    else if (key === 'delete' || key === 'backspace') {
      if (!labels.deleteChosen()) return;
    } else return;
    event.preventDefault();
  });
}
