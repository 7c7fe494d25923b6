/** The bar under a stage: play, step, speed, loop, and a timeline with what happens when. */

import { clock, element } from './dom.js';
import { icon } from './icons.js';
import { hearKeys } from './keys.js';
import { drawTimeline } from './timeline.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const LONGEST_GAP = 0.5;

/**
 * A player of a stage's time.
 * @param {object} stage of stage.js
 * @param {HTMLElement} parent takes the bar
 * @param {{live?: boolean}} options live: the app sets the time, the bar is hidden
 */
export function createPlayer(stage, parent, { live = false } = {}) {
  const state = { time: 0, begin: 0, seconds: 0, frame: 1 / 30, playing: false, speed: 1, loop: true, last: null, live };
  const heard = [];
  const make = (name, picture, title, click) => element('button', {
    type: 'button', class: 'mg-button mg-icon', title, 'aria-label': title, 'data-name': name,
    on: { click },
  }, icon(picture));
  const play = make('play', 'play', 'Play (space)', () => player.toggle());
  const back = make('step-back', 'back', 'One frame back (←)', () => player.step(-1));
  const on = make('step-on', 'on', 'One frame on (→)', () => player.step(1));
  const loop = make('loop', 'loop', 'Again from the beginning', () => { player.loop = !state.loop; });
  const reading = element('output', { class: 'mg-clock', 'data-name': 'clock' });
  const speed = element('select', {
    class: 'mg-speed', 'data-name': 'speed', 'aria-label': 'Speed', title: 'Speed',
    on: { change: () => { player.speed = SPEEDS[speed.selectedIndex]; } },
  }, ...SPEEDS.map((value) => element('option', { text: `${value}×`, value })));
  const scrub = element('input', {
    type: 'range', class: 'mg-scrub', min: 0, max: 1, step: 'any', 'data-name': 'scrub',
    'aria-label': 'Time',
    on: { input: () => seek(Number(scrub.value)) },
  });
  const lanes = element('div', { class: 'mg-lanes' });
  const bar = element('div', { class: 'mg-player', role: 'group', 'aria-label': 'Playback', hidden: live },
    element('div', { class: 'mg-controls' }, back, play, on, reading, speed, loop), lanes);
  parent.append(bar);
  let timeline = drawTimeline(lanes, scrub, {}, seek);

  /** Goes to a second because the person wants to. */
  function seek(time) {
    player.seek(time);
    heard.forEach((callback) => callback(state.time));
  }

  function show() {
    stage.time = state.time;
    reading.textContent = `${clock(state.time)} / ${clock(state.seconds)}`;
    scrub.value = state.time;
    scrub.setAttribute('aria-valuetext', `${state.time.toFixed(2)} seconds`);
    timeline.at(state.time);
  }

  function tick(now) {
    if (!state.playing || state.live) return false;
    const passed = state.last === null ? 0 : Math.min(LONGEST_GAP, (now - state.last) / 1000);
    state.last = now;
    let time = state.time + passed * state.speed;
    if (time >= state.seconds) {
      if (state.loop && state.seconds > state.begin) {
        time = state.begin + ((time - state.begin) % (state.seconds - state.begin));
      }
      else {
        time = state.seconds;
        player.pause();
      }
    }
    state.time = time;
    show();
    return state.playing;
  }

  function onKey(event) {
    if (state.live) return false;
    const jump = event.shiftKey ? Math.round(1 / state.frame) : 1;
    const keys = {
      ' ': () => player.toggle(),
      ArrowLeft: () => player.step(-jump),
      ArrowRight: () => player.step(jump),
      Home: () => seek(state.begin),
      End: () => seek(state.seconds),
    };
    keys[event.key]?.();
    return Object.hasOwn(keys, event.key);
  }

  function markPlaying(playing) {
    Object.assign(state, { playing, last: null });
    play.replaceChildren(icon(playing ? 'pause' : 'play'));
    play.title = playing ? 'Pause (space)' : 'Play (space)';
    play.setAttribute('aria-label', play.title);
    bar.dataset.playing = String(playing);
  }

  const player = {
    element: bar,
    /** The length and the timeline of a show; time goes to its beginning, or `begin` (s). */
    setShow({ begin = 0, seconds, actors = [], spans = [], moments = [] }) {
      state.begin = Math.max(0, begin);
      state.seconds = Math.max(state.begin, seconds);
      state.frame = 1 / Math.max(1, ...actors.map(({ frames }) => Math.min(120, frames.rate)));
      scrub.max = state.seconds;
      scrub.min = state.begin;
      const times = { begin: state.begin, seconds: state.seconds };
      timeline = drawTimeline(lanes, scrub, { ...times, spans, moments }, seek);
      state.time = state.begin;
      show();
    },
    play() {
      if (state.live) return;
      if (state.time >= state.seconds) state.time = state.begin;
      markPlaying(true);
      stage.wake(false);
    },
    pause: () => markPlaying(false),
    toggle: () => (state.playing ? player.pause() : player.play()),
    /** Goes to a second. */
    seek(time) {
      state.time = Math.min(state.seconds, Math.max(state.begin, time));
      show();
    },
    /** Pauses and goes on by frames, back where negative. */
    step(frames) {
      player.pause();
      seek((Math.round(state.time / state.frame) + frames) * state.frame);
    },
    get time() { return state.time; },
    get seconds() { return state.seconds; },
    /** Second at which the bar begins. */
    get begin() { return state.begin; },
    get playing() { return state.playing; },
    get speed() { return state.speed; },
    /** Seconds of the show in one of the clock, 0.1 … 4. */
    set speed(value) {
      state.speed = Math.min(4, Math.max(0.1, value));
      const near = SPEEDS.map((each) => Math.abs(Math.log(each / state.speed)));
      speed.selectedIndex = near.indexOf(Math.min(...near));
    },
    get loop() { return state.loop; },
    set loop(value) {
      state.loop = Boolean(value);
      loop.setAttribute('aria-pressed', String(state.loop));
    },
    get live() { return state.live; },
    /** The app sets the stage's time, and the bar is hidden. */
    set live(value) {
      state.live = Boolean(value);
      bar.hidden = state.live;
      if (state.live) player.pause();
    },
    /** Called with the second when the person has gone to one; returns what ends it. */
    onSeek(callback) {
      heard.push(callback);
      return () => heard.splice(heard.indexOf(callback), 1);
    },
    dispose() {
      player.pause();
      stops.forEach((stop) => stop());
      bar.remove();
    },
  };

  const stops = [stage.onTick(tick), hearKeys([bar, stage.canvas], onKey)];
  player.speed = 1;
  player.loop = true;
  show();
  return player;
}
