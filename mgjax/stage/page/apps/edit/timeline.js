/** The timeline of a clip, on which labels are made, dragged, and chosen. */

import { element } from '../../dom.js';
import { kindColour, labelWords, themed } from './colours.js';
import { dragged, framesOf, markStep, room } from './spans.js';

const LEAST_DRAG = 4;
const LEAST_FOR_WORDS = 44;
const MOST_PER_SECOND = 900;

/**
 * @param {HTMLElement} parent
 * @param {object} calls onAdd({start, stop}), onMove(id, {start?, stop?}), onChoose(id), onDelete(id),
 *   onSeek(seconds), say(text)
 */
export function createTimeline(parent, calls) {
  const state = { clip: null, labels: [], chosen: null, perSecond: 0, fitted: true, drag: null, waiting: null };
  const ruler = element('div', { class: 'ed-ruler', 'data-name': 'ruler', title: 'Click: go there' });
  const lane = element('div', { class: 'ed-lane', 'data-name': 'lane' });
  const head = element('div', { class: 'ed-head' });
  const track = element('div', { class: 'ed-track' }, ruler, lane, head);
  const hint = element('p', { class: 'mg-empty ed-hint', text: 'Pick a clip to see its labels.' });
  const scroll = element('div', { class: 'ed-time', 'data-name': 'timeline' }, hint, track);
  parent.append(scroll);
  track.hidden = true;

  const fit = () => Math.max(1, (scroll.clientWidth - 24) / Math.max(seconds(), 0.1));
  const seconds = () => (state.clip ? state.clip.frames / state.clip.rate : 0);
  const xOf = (frame) => (frame / state.clip.rate) * state.perSecond;
  const frameAt = (event) => {
    const box = track.getBoundingClientRect();
    return ((event.clientX - box.left) / state.perSecond) * state.clip.rate;
  };

  function layOut() {
    if (!state.clip) return;
    if (state.fitted) state.perSecond = fit();
    track.style.width = `${seconds() * state.perSecond}px`;
    drawRuler();
    draw();
  }

  function drawRuler() {
    const step = markStep(state.perSecond, 58);
    const marks = [];
    for (let n = 0; n * step <= seconds() + 1e-6 && n < 4000; n += 1) {
      const mark = element('span', { text: `${Number((n * step).toFixed(1))} s` });
      mark.style.left = `${n * step * state.perSecond}px`;
      marks.push(mark);
    }
    ruler.replaceChildren(...marks);
  }

  /** Labels in frames, with what is being dragged where it is dragged to. */
  function draw() {
    lane.replaceChildren(...state.labels.map(labelElement));
    const { drag } = state;
    if (drag?.part === 'new' && drag.stop > drag.start) {
      const fresh = element('div', { class: 'ed-label ed-new' });
      place(fresh, drag);
      lane.append(fresh);
    }
  }

  function place(made, { start, stop }) {
    made.style.left = `${xOf(start)}px`;
    const wide = Math.max(3, xOf(stop) - xOf(start));
    made.style.width = `${wide}px`;
    made.classList.toggle('ed-narrow', wide < LEAST_FOR_WORDS);
  }

  function labelElement(label) {
    const chosen = label.id === state.chosen;
    const edge = (part) => element('span', {
      class: `ed-edge ed-${part}`, tabIndex: chosen ? 0 : -1, role: 'slider',
      'data-name': `label-${label.id}-${part}`, 'data-part': part,
      'aria-label': `${part === 'start' ? 'Start' : 'End'} of ${labelWords(label)}`,
      'aria-valuenow': label[part], 'aria-valuemin': 0, 'aria-valuemax': state.clip.frames,
      'aria-valuetext': `${(label[part] / state.clip.rate).toFixed(2)} seconds`,
    });
    const made = element('div', {
      class: 'ed-label', tabIndex: 0, role: 'button', 'data-name': `label-${label.id}`,
      'data-id': label.id, 'aria-pressed': String(chosen),
      'aria-label': `${labelWords(label)}, ${label.start_s.toFixed(2)} to ${label.end_s.toFixed(2)} seconds`,
      title: `${labelWords(label)}\n${label.start_s.toFixed(2)} … ${label.end_s.toFixed(2)} s`,
    }, edge('start'), element('span', { class: 'ed-words', text: arrowed(label) }), edge('stop'));
    made.style.setProperty('--hue', kindColour(label.kind));
    made.classList.toggle('ed-exercise', !label.genuine);
    place(made, state.drag?.id === label.id ? state.drag : label);
    return made;
  }

  function choose(id, focus = true) {
    state.chosen = id;
    draw();
    if (focus && id !== null) find(id)?.focus({ preventScroll: true });
    calls.onChoose(id);
  }

  const find = (id) => lane.querySelector(`[data-id='${id}']`);
  const othersOf = (id) => state.labels.filter((label) => label.id !== id);

  function begin(event) {
    if (event.button !== 0 || !state.clip) return;
    const target = event.target.closest('.ed-label');
    const at = Math.round(frameAt(event));
    if (target) {
      const label = state.labels.find(({ id }) => id === Number(target.dataset.id));
      const part = event.target.dataset.part ?? 'whole';
      const { start, stop } = label;
      state.drag = {
        id: label.id, part, from: frameAt(event), x: event.clientX, start, stop, was: { start, stop },
        room: room(othersOf(label.id), label, state.clip.frames),
      };
      choose(label.id);
    } else {
      const here = { start: at, stop: at };
      const free = room(state.labels, here, state.clip.frames);
      state.drag = { id: null, part: 'new', at, x: event.clientX, ...here, room: free };
      choose(null);
    }
    lane.setPointerCapture(event.pointerId);
    event.preventDefault();
  }

  function move(event) {
    const { drag } = state;
    if (!drag || (!drag.moved && Math.abs(event.clientX - drag.x) < LEAST_DRAG)) return;
    drag.moved = true;
    if (drag.part === 'new') {
      const at = Math.round(frameAt(event));
      const [a, b] = [Math.min(at, drag.at), Math.max(at, drag.at)];
      Object.assign(drag, { start: Math.max(a, drag.room.low), stop: Math.min(b, drag.room.high) });
      if (a < drag.room.low || b > drag.room.high) blocked(a < drag.room.low ? drag.room.before : drag.room.after);
    } else {
      const by = Math.round(frameAt(event) - drag.from);
      const next = dragged(drag.was, drag.part, by, drag.room);
      Object.assign(drag, { start: next.start, stop: next.stop });
      if (next.blocked) blocked(next.blocked);
    }
    draw();
  }

  function blocked(by) {
    if (!by || by === 'end') calls.say('A label ends with its clip.');
    else calls.say(`Labels may touch, not overlap: ${labelWords(by)} is at ${by.start_s.toFixed(2)} … ${by.end_s.toFixed(2)} s.`);
  }

  function end() {
    const { drag } = state;
    state.drag = null;
    if (drag?.moved) {
      if (drag.part === 'new') {
        if (drag.stop > drag.start) calls.onAdd({ start: drag.start, stop: drag.stop });
      } else send(drag.id, drag.was, drag);
    }
    if (state.waiting) timeline.setLabels(state.waiting);
    else draw();
    if (drag && drag.id !== null) find(drag.id)?.focus({ preventScroll: true });
  }

  function send(id, was, { start, stop }) {
    const what = {};
    if (start !== was.start) what.start = start;
    if (stop !== was.stop) what.stop = stop;
    if (!Object.keys(what).length) return;
    state.labels = state.labels.map((label) => (label.id === id ? { ...label, start, stop } : label));
    calls.onMove(id, what);
  }

  function onKey(event) {
    const label = state.labels.find(({ id }) => id === Number(event.target.closest('.ed-label')?.dataset.id));
    if (!label || event.ctrlKey || event.metaKey) return;
    const part = event.target.dataset.part ?? 'whole';
    if (event.key === 'ArrowLeft' || event.key === 'ArrowRight') {
      const by = (event.key === 'ArrowLeft' ? -1 : 1) * (event.shiftKey ? 10 : 1);
      const next = dragged(label, part, by, room(othersOf(label.id), label, state.clip.frames));
      if (next.blocked) blocked(next.blocked);
      send(label.id, label, next);
      draw();
      const again = find(label.id);
      (part === 'whole' ? again : again?.querySelector(`[data-part='${part}']`))?.focus({ preventScroll: true });
    } else if (event.key === 'Enter' || event.key === ' ') choose(label.id);
    else if (event.key === 'Delete' || event.key === 'Backspace') calls.onDelete(label.id);
    else return;
    event.preventDefault();
  }

  function seekTo(event) {
    if (state.clip) calls.onSeek(Math.min(seconds(), Math.max(0, frameAt(event) / state.clip.rate)));
  }

  lane.addEventListener('pointerdown', begin);
  lane.addEventListener('pointermove', move);
  lane.addEventListener('pointerup', end);
  lane.addEventListener('pointercancel', () => { state.drag = null; draw(); });
  lane.addEventListener('keydown', onKey);
  ruler.addEventListener('pointerdown', (event) => {
    ruler.setPointerCapture(event.pointerId);
    seekTo(event);
  });
  ruler.addEventListener('pointermove', (event) => {
    if (ruler.hasPointerCapture(event.pointerId)) seekTo(event);
  });
  scroll.addEventListener('wheel', (event) => {
    if (!event.ctrlKey || !state.clip) return;
    zoom(Math.exp(-event.deltaY / 300), event.clientX);
    event.preventDefault();
  }, { passive: false });
  new ResizeObserver(() => { if (state.fitted) layOut(); }).observe(scroll);

  function zoom(factor, clientX = scroll.getBoundingClientRect().left + scroll.clientWidth / 2) {
    const left = scroll.getBoundingClientRect().left;
    const time = (clientX - left + scroll.scrollLeft - 12) / state.perSecond;
    state.perSecond = Math.min(MOST_PER_SECOND, Math.max(fit(), state.perSecond * factor));
    state.fitted = state.perSecond <= fit() * 1.001;
    layOut();
    scroll.scrollLeft = time * state.perSecond + 12 - (clientX - left);
  }

  const timeline = {
    element: scroll,
    /** `{name, frames, rate}`, or null. */
    setClip(clip) {
      Object.assign(state, { clip, labels: [], chosen: null, fitted: true, drag: null, waiting: null });
      track.hidden = !clip;
      hint.hidden = Boolean(clip);
      layOut();
    },
    setLabels(labels) {
      state.waiting = state.drag ? labels : null;
      if (!state.clip || state.drag) return;
      state.labels = labels.map((label) => ({ ...label, ...framesOf(label, state.clip.rate) }));
      if (!state.labels.some(({ id }) => id === state.chosen)) state.chosen = null;
      const focused = lane.contains(document.activeElement) ? document.activeElement.dataset.name : null;
      draw();
      if (focused) lane.querySelector(`[data-name='${focused}']`)?.focus({ preventScroll: true });
      calls.onChoose(state.chosen);
    },
    choose,
    get chosen() { return state.labels.find(({ id }) => id === state.chosen) ?? null; },
    zoom,
    fit() {
      state.fitted = true;
      layOut();
    },
    /** The head goes to a second, and stays in view while it moves. */
    at(time, follow) {
      if (!state.clip) return;
      const x = Math.min(time, seconds()) * state.perSecond;
      head.style.transform = `translateX(${x}px)`;
      head.style.background = themed('--accent');
      if (!follow || state.drag) return;
      const seen = x - scroll.scrollLeft;
      if (seen < 0 || seen > scroll.clientWidth - 40) scroll.scrollLeft = Math.max(0, x - 60);
    },
  };
  return timeline;
}

function arrowed({ kind, direction }) {
  const arrow = { left: ' ←', right: ' →' }[direction] ?? (direction ? ` ${direction}` : '');
  return kind + arrow;
}
