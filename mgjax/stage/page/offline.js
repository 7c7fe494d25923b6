/** A show in a page of its own, or in a notebook's cell: no server, no network. */

import { element } from './dom.js';
import { showInfo } from './info.js';
import { unpack } from './packet.js';
import { createPlayer } from './player.js';
import { createStage } from './stage.js';
import * as ui from './ui.js';

/**
 * Plays a show in an element. The stage is there only while the element is in view: a browser keeps
 * few of them.
 * @param {HTMLElement} root
 * @param {ArrayBuffer} packet of a show (types.py `Show`)
 * @param {object} options `dark` (true, false; else as the system), `play` (false: stands still at
 *   first), `follow` (id of an actor), `time` (s at which it begins), `bare` (true: no words at the side)
 * @returns {{stage: object | null, player: object | null, stop(): void}} also as `window.mgjax`
 */
export function start(root, packet, options = {}) {
  const show = unpack(packet);
  const kept = { camera: null, time: options.time ?? 0, playing: options.play ?? !calm(),
    speed: 1, loop: true, follow: options.follow ?? walker(show), dark: options.dark ?? ui.systemDark() };
  const page = layOut(root, show, options.bare ?? false);
  let now = { stage: null, player: null };

  function open() {
    try {
      now = openStage(page, show, kept);
    } catch (error) {
      page.view.replaceChildren(element('p', { class: 'mg-message', text: sentenceOf(error) }));
    }
  }

  function close() {
    const { stage, player, close: closeStage } = now;
    if (!stage) return;
    const { yaw, pitch, distance, target } = stage.camera;
    Object.assign(kept, { camera: { yaw, pitch, distance, target }, time: player.time,
      playing: player.playing, speed: player.speed, loop: player.loop, follow: stage.follow,
      dark: stage.dark });
    closeStage();
    now = { stage: null, player: null };
  }

  const seen = new IntersectionObserver((entries) => {
    const inView = entries.at(-1).isIntersecting;
    if (inView && !now.stage) open();
    else if (!inView) close();
  });
  seen.observe(page.view);
  const handle = {
    get stage() { return now.stage; },
    get player() { return now.player; },
    link: null,
    stop() {
      seen.disconnect();
      close();
      root.replaceChildren();
    },
  };
  window.mgjax = handle;
  return handle;
}

const calm = () => matchMedia('(prefers-reduced-motion: reduce)').matches;

/** In a frame that may not save files, as in a notebook. */
const confined = () => window.top !== window && window.origin === 'null';

const sentenceOf = (error) => `${error.message[0].toUpperCase()}${error.message.slice(1)}.`;

/** The only one who moves, if there is one and it goes farther than a step or two. */
function walker({ actors = [] }) {
  if (actors.length !== 1) return null;
  const { root } = actors[0].frames;
  let [low, high] = [[Infinity, Infinity], [-Infinity, -Infinity]];
  for (let i = 0; i + 2 < root.length; i += 3) {
    low = [Math.min(low[0], root[i]), Math.min(low[1], root[i + 2])];
    high = [Math.max(high[0], root[i]), Math.max(high[1], root[i + 2])];
  }
  return Math.max(high[0] - low[0], high[1] - low[1]) > 2 ? actors[0].id : null;
}

/** View, bar and, where the show says anything, a side. */
function layOut(root, show, bare) {
  root.className = 'mg-page mg-bare';
  const side = element('aside', { class: 'mg-side', 'aria-label': 'What is shown' });
  const view = element('main', { class: 'mg-view' });
  const under = element('div', { class: 'mg-under' });
  root.replaceChildren(view, under);
  const small = matchMedia('(max-width: 759px)').matches;
  if (!bare && showInfo(side, show, { open: !small })) {
    root.append(side);
    root.classList.add('mg-told');
  }
  if (show.title) document.title = show.title;
  return { view, under, side };
}

function openStage({ view, under, side }, show, kept) {
  const canvas = element('canvas', {
    class: 'mg-canvas', tabIndex: 0, role: 'img',
    'aria-label': `${show.title || 'A motion'}: drag to turn, wheel to zoom`,
  });
  view.replaceChildren(canvas);
  const stage = createStage(canvas, {
    dark: kept.dark, wheel: window.top === window ? 'always' : 'focused',
  });
  const player = createPlayer(stage, under);
  stage.setShow(show);
  player.setShow(show);
  stage.follow = kept.follow;
  player.speed = kept.speed;
  player.loop = kept.loop;
  player.seek(kept.time);
  if (kept.camera) Object.assign(stage.camera, kept.camera);
  else stage.frameAll();
  ui.setDark(stage, kept.dark);
  const buttons = corner(stage, show);
  view.append(buttons);
  stage.keepClear(buttons, side);
  if (kept.playing && show.seconds > 0) player.play();
  return {
    stage, player,
    close() {
      player.dispose();
      stage.dispose();
      view.replaceChildren();
    },
  };
}

/** Buttons over the picture: all in view, follow, light or dark, save a picture. */
function corner(stage, show) {
  const box = element('div', { class: 'mg-corner' });
  const icon = (picture, title, onClick) => ui.iconButton(box, { picture, title, onClick });
  icon('frame', 'All in the picture', () => stage.frameAll());
  if (show.actors?.length) {
    const follow = icon('follow', 'Follow with the camera', () => {
      stage.follow = stage.follow === null ? show.actors[0].id : null;
      follow.setAttribute('aria-pressed', String(stage.follow !== null));
    });
    follow.setAttribute('aria-pressed', String(stage.follow !== null));
  }
  ui.themeButton(box, stage);
  if (confined()) return box;
  icon('picture', 'Save a picture', () => {
    const data = stage.snapshot();
    if (!data) return;
    const bytes = Uint8Array.from(atob(data.split(',')[1]), (letter) => letter.charCodeAt(0));
    ui.download(`${show.title || 'mgjax'}.png`, bytes, 'image/png');
  });
  return box;
}
