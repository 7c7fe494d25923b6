/** The graph as a picture: clips as rows, transitions as arcs, labels coloured, pruned parts hatched. */

import { element } from '../../dom.js';
import { BAR, clipAt, curve, distanceTo, drawn, heightOf, NAMES, rowY } from './arcs.js';
import { labelWords } from './colours.js';
import { paintGraph } from './graph_paint.js';

const NEAR_PX = 6;
const MOST_PER_SECOND = 500;

/**
 * @param {HTMLElement} parent
 * @param {{onTransition(edge: number): void, onClip(name: string): void, say(text: string): void}} calls
 */
export function createGraphPicture(parent, calls) {
  const state = {
    graph: null, clip: null, most: 400, shown: [], curves: new Map(), perSecond: 20, fitted: true, over: null, chosen: null, asked: 0,
  };
  const canvas = element('canvas', {
    class: 'ed-graph-canvas', tabIndex: 0, 'data-name': 'graph', role: 'img',
    'aria-label': 'The graph: arrow keys go from transition to transition, Enter plays one',
  });
  const space = element('div', { class: 'ed-graph-space' }, canvas);
  const empty = element('p', { class: 'mg-empty ed-hint', text: 'There is no graph yet: Build graph makes one.' });
  const scroll = element('div', { class: 'ed-graph' }, empty, space);
  const tip = element('div', { class: 'ed-tip', hidden: true });
  parent.append(scroll, tip);
  space.hidden = true;

  const seconds = () => Math.max(...state.graph.clips.map(({ frames }) => frames)) / state.graph.rate;
  const fit = () => Math.max(1, (scroll.clientWidth - NAMES - 16) / seconds());
  const xOf = (frame) => NAMES + (frame / state.graph.rate) * state.perSecond;

  function layOut() {
    const { graph } = state;
    if (!graph || !scroll.clientWidth) return;
    if (state.fitted) state.perSecond = fit();
    space.style.width = `${NAMES + seconds() * state.perSecond + 12}px`;
    space.style.height = `${heightOf(graph.clips)}px`;
    const { transitions: t } = graph;
    state.shown = drawn(t, state.clip, state.most);
    [state.near, state.far] = state.shown.length
      ? [t.distance[state.shown[0]], t.distance[state.shown.at(-1)]] : [0, 0];
    state.curves = new Map(state.shown.map((n) => [n, curve({
      fromClip: t.from_clip[n], fromX: xOf(t.from_frame[n]), toClip: t.to_clip[n], toX: xOf(t.to_frame[n]),
    })]));
    ask();
  }

  function ask() {
    if (!state.asked) state.asked = requestAnimationFrame(() => { state.asked = 0; paint(); });
  }

  function paint() {
    const { graph } = state;
    const [wide, high] = [scroll.clientWidth, scroll.clientHeight];
    if (!graph || !wide || !high) return;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    Object.assign(canvas.style, { width: `${wide}px`, height: `${high}px` });
    Object.assign(canvas, { width: wide * ratio, height: high * ratio });
    const paper = canvas.getContext('2d');
    paper.scale(ratio, ratio);
    paper.translate(-scroll.scrollLeft, -scroll.scrollTop);
    paintGraph(paper, {
      ...state, xOf, seconds: seconds(), wide, high, left: scroll.scrollLeft, top: scroll.scrollTop,
    });
  }

  /** Where the pointer is in the whole picture. */
  function placeOf(event) {
    const box = scroll.getBoundingClientRect();
    return [event.clientX - box.left + scroll.scrollLeft, event.clientY - box.top + scroll.scrollTop];
  }

  function nearest(x, y) {
    let [best, least] = [null, NEAR_PX];
    for (const [n, points] of state.curves) {
      const far = distanceTo(points, x, y);
      if (far < least) [best, least] = [n, far];
    }
    return best;
  }

  function inNames(event) {
    return event.clientX - scroll.getBoundingClientRect().left < NAMES - 6;
  }

  function hover(event) {
    if (!state.graph) return;
    const [x, y] = placeOf(event);
    const over = inNames(event) ? null : nearest(x, y);
    canvas.style.cursor = over !== null || inNames(event) ? 'pointer' : '';
    const text = over === null ? labelTip(x, y) : words(over);
    tip.hidden = !text;
    tip.textContent = text;
    const box = parent.getBoundingClientRect();
    tip.style.left = `${Math.min(event.clientX - box.left + 14, box.width - 250)}px`;
    tip.style.top = `${event.clientY - box.top - 34}px`;
    if (over !== state.over) {
      state.over = over;
      ask();
    }
  }

  function labelTip(x, y) {
    const clip = clipAt(y, state.graph.clips);
    if (Math.abs(y - rowY(clip)) > BAR) return '';
    const label = state.graph.labels.find((each) => each.clip === clip && x >= xOf(each.start) && x <= xOf(each.stop));
    if (!label) return '';
    if (!label.kept) return `${labelWords(label)}: not in the graph`;
    return `${labelWords(label)}${label.enterable ? '' : ': no walk gets into it in time'}`;
  }

  function words(n) {
    const { clips, rate, transitions: t } = state.graph;
    const end = (clip, frame) => `${clips[clip].name} ${(frame / rate).toFixed(2)} s`;
    return `${end(t.from_clip[n], t.from_frame[n])} → ${end(t.to_clip[n], t.to_frame[n])}, ${(100 * t.distance[n]).toFixed(1)} cm`;
  }

  function pick(n) {
    state.chosen = n;
    ask();
    if (n !== null) calls.onTransition(state.graph.transitions.edge[n]);
  }

  function click(event) {
    if (!state.graph) return;
    const [x, y] = placeOf(event);
    if (inNames(event)) {
      const clip = clipAt(y, state.graph.clips);
      if (clip >= 0) calls.onClip(state.graph.clips[clip].name);
      return;
    }
    const n = nearest(x, y);
    if (n !== null) pick(n);
    else calls.say('Click on an arc to see that transition, or on a name to see only its own.');
  }

  function onKey(event) {
    const by = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (by && state.shown.length) picture.step(by);
    else if (event.key === 'Enter' && state.chosen !== null) pick(state.chosen);
    else return;
    event.preventDefault();
  }

  canvas.addEventListener('pointermove', hover);
  canvas.addEventListener('pointerleave', () => {
    tip.hidden = true;
    state.over = null;
    ask();
  });
  canvas.addEventListener('click', click);
  canvas.addEventListener('keydown', onKey);
  scroll.addEventListener('scroll', ask);
  scroll.addEventListener('wheel', (event) => {
    if (!event.ctrlKey || !state.graph) return;
    picture.zoom(Math.exp(-event.deltaY / 300), event.clientX);
    event.preventDefault();
  }, { passive: false });
  new ResizeObserver(layOut).observe(scroll);

  const picture = {
    element: scroll,
    setGraph(graph) {
      Object.assign(state, { graph, chosen: null, over: null });
      empty.hidden = true;
      space.hidden = false;
      layOut();
    },
    /** Only transitions of a clip, by its name; null: of all. Pieces of a split clip count as it. */
    setClip(name) {
      const found = state.graph?.clips.findIndex((clip) => clip.name === name || clip.name.startsWith(`${name}#`));
      state.clip = name === null || found === undefined || found < 0 ? null : found;
      layOut();
      if (state.clip === null) return;
      const y = rowY(state.clip);
      if (y < scroll.scrollTop + 40 || y > scroll.scrollTop + scroll.clientHeight - 20) {
        scroll.scrollTop = y - scroll.clientHeight / 2;
      }
    },
    setMost(most) {
      state.most = most;
      layOut();
    },
    /** The next or previous transition of those drawn, from the nearest to the farthest. */
    step(by) {
      const at = state.shown.indexOf(state.chosen);
      const next = at < 0 ? 0 : (at + by + state.shown.length) % state.shown.length;
      if (state.shown.length) pick(state.shown[next]);
    },
    get counts() {
      return { shown: state.shown.length, all: state.graph?.transitions.edge.length ?? 0 };
    },
    /** Distances of the nearest and the farthest that is drawn, m. */
    get range() { return [state.near, state.far]; },
    zoom(factor, clientX = scroll.getBoundingClientRect().left + scroll.clientWidth / 2) {
      if (!state.graph) return;
      const offset = clientX - scroll.getBoundingClientRect().left;
      const time = (offset + scroll.scrollLeft - NAMES) / state.perSecond;
      state.perSecond = Math.min(MOST_PER_SECOND, Math.max(fit(), state.perSecond * factor));
      state.fitted = state.perSecond <= fit() * 1.001;
      layOut();
      scroll.scrollLeft = time * state.perSecond + NAMES - offset;
    },
    fit() {
      state.fitted = true;
      layOut();
    },
    redraw: ask,
    /** For tests: where on the page the middle of a drawn transition lies. */
    middleOf(n) {
      const points = state.curves.get(n);
      const box = scroll.getBoundingClientRect();
      const k = 2 * Math.floor(points.length / 4);
      return [points[k] - scroll.scrollLeft + box.left, points[k + 1] - scroll.scrollTop + box.top];
    },
    get shown() { return state.shown; },
  };
  return picture;
}
