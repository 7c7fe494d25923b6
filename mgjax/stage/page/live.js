/** The live page: a stage, a player and a side, for the application that the server names. */

import { element } from './dom.js';
import { openLink } from './link.js';
import { createPlayer } from './player.js';
import { createStage } from './stage.js';
import * as ui from './ui.js';

const APPS = {
  throw: () => import('./apps/throw.js'),
  sketch: () => import('./apps/sketch.js'),
  match: () => import('./apps/match.js'),
  edit: () => import('./apps/edit.js'),
  show: () => import('./apps/show.js'),
};

function begin() {
  const view = document.getElementById('view');
  const side = document.getElementById('side');
  const stage = stageOrWords(view);
  if (!stage) return;
  const player = createPlayer(stage, document.getElementById('bar'), { live: true });
  const corner = element('div', { class: 'mg-corner' });
  view.append(corner);
  followButton(corner, stage);
  ui.themeButton(corner, stage);
  stage.keepClear(corner);
  const waiting = element('div', { class: 'mg-waiting' });
  view.append(waiting);
  const progress = ui.progress(waiting);
  const trouble = ui.sentence(waiting, 'trouble');
  trouble.set('');
  progress.set(0, 'connecting');

  const link = openLink('/link');
  let running = false;
  let failed = false;
  link.on('progress', ({ share, text }) => {
    if (!running) progress.set(Math.min(share, 0.999), text);
  });
  link.on('sentence', ({ text, tone }) => {
    if (running) return;
    failed = tone === 'bad';
    trouble.set(text, tone);
  });
  link.on('file', ({ name, mime, data }) => ui.download(name, data, mime));
  link.on('show', ({ show }) => {
    stage.setShow(show);
    player.setShow(show);
  });
  link.on('put', ({ kind, item }) => stage.put(kind, item));
  link.on('remove', ({ kind, id }) => stage.remove(kind, id));
  link.on('frames', ({ actor, frames }) => stage.pushFrames(actor, frames));
  link.on('ready', async ({ app, title, options }) => {
    if (running) {
      location.reload(); // the session of before is gone
      return;
    }
    running = true;
    document.title = `${title} – mgjax`;
    const held = hold(link);
    const { start } = await APPS[app]();
    start({ stage, player, ui, side, view, link, options });
    held.release();
    waiting.hidden = true;
    document.documentElement.dataset.ready = app;
  });
  link.onClose((reason) => {
    waiting.hidden = false;
    progress.set(1);
    if (!failed) trouble.set(reason || 'The connection is lost; trying again.', 'bad');
  });
  link.onOpen(() => {
    failed = false;
    trouble.set('');
  });
  globalThis.mgjax = { stage, player, link };
}

/** The stage, or null and a sentence where the browser cannot draw it. */
function stageOrWords(view) {
  try {
    return createStage(document.getElementById('canvas'), { dark: ui.systemDark() });
  } catch (error) {
    view.append(element('p', { class: 'mg-message', text: `There is nothing to see: ${error.message}.` }));
    return null;
  }
}

/** Keeps messages that come while the application's program is still loading. */
function hold(link) {
  const kept = [];
  const stops = ['note', 'sentence', 'show'].map((type) => link.on(type, (message) => kept.push(message)));
  return {
    release() {
      stops.forEach((stop) => stop());
      kept.forEach((message) => link.replay(message));
    },
  };
}

function followButton(parent, stage) {
  const made = ui.iconButton(parent, {
    picture: 'follow', title: 'The camera follows', onClick() {
      const [first] = stage.scene.actors.keys();
      stage.follow = stage.follow === null ? first ?? null : null;
      show();
    },
  });
  function show() {
    made.setAttribute('aria-pressed', String(stage.follow !== null));
  }
  stage.onFrame(show);
}

begin();
