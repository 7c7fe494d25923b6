/** Match: players pass a ball; a click says who gets it, buttons how, a body's kick as well. */

import { savePanel } from '../save.js';
import { createSide } from './match/side.js';
import { createMarks } from './match/marks.js';

const HEARD_MS = 50;
const WINDOW_SECONDS = 30;
const NEAR_METRES = 0.7;

/** Starts the application; see live.js for what it is given. */
export function start({ stage, player, ui, side, link }) {
  const game = {
    number: 0, players: [], passes: [], bounces: [], known: 0,
    holder: '', picked: [], waits: false, sent: -1,
  };
  const marks = createMarks(stage);
  const panel = createSide(ui, side, {
    pick: (name) => link.send({ type: 'pick', player: name }),
    send: (message) => link.send(message),
  });
  savePanel({ stage, player, ui, side, link, formats: [] });
  player.live = false;
  player.loop = false;

  const told = {
    match({ game: number, players, net, clips }) {
      Object.assign(game, { number, players, passes: [], bounces: [], known: 0, sent: -1 });
      panel.begin({ players, net, clips });
      stage.frameAll();
    },
    played({ game: number, known, passes, bounces, spans, table }) {
      if (number !== game.number) return;
      const starved = !player.playing && player.time >= game.known - 1e-3;
      const playing = player.playing || starved;
      const { time } = player;
      Object.assign(game, { known, passes, bounces });
      const begin = Math.max(0, known - WINDOW_SECONDS);
      player.setShow({
        begin, seconds: known, actors: [{ frames: { rate: 60 } }],
        spans: spans.filter(({ end }) => end > begin),
      });
      player.seek(time);
      if (playing) player.play();
      panel.table(table);
      now(true);
    },
    wishes({ holder, waits, picked, on, kind, bounces }) {
      Object.assign(game, { holder, waits, picked });
      panel.wishes({ on, kind, bounces, picked });
      now(true);
    },
    user: ({ text, tone }) => panel.user(text, tone),
    busy: ({ text }) => panel.busy(text),
  };
  link.on('put', ({ kind, item }) => {
    if (kind === 'actors' && item.id === 'user') wholeInView();
  });
  link.on('note', (message) => told[message.what]?.(message));
  link.on('sentence', ({ text, tone }) => panel.trouble(text, tone));

  /** The camera goes back where the user's body would be out of the picture. */
  function wholeInView() {
    const { low } = stage.scene.actors.get('user').pose;
    const place = stage.project(low);
    const { clientWidth, clientHeight } = stage.canvas;
    const inside = place && place[0] > 60 && place[0] < clientWidth - 60
      && place[1] > 80 && place[1] < clientHeight - 20;
    if (!inside) stage.frameAll();
  }

  /** What is marked and said at the second that is shown. */
  function now(always = false) {
    const state = stateAt(game, player.time);
    if (!always && state.key === game.key) return;
    game.key = state.key;
    marks.set(state, game.players);
    panel.now(state, game);
  }

  stage.onFrame(() => now());
  player.onSeek(() => now());
  stage.onClick(({ body, floor }) => {
    const name = playerAt(game.players, body, floor);
    if (name) link.send({ type: 'pick', player: name });
  });

  /** Tells which second is played, a little ahead where it runs fast. */
  setInterval(() => {
    const ahead = player.playing ? 0.3 * Math.max(0, player.speed - 1) : 0;
    const time = Math.min(game.known, player.time + ahead);
    const starved = player.time >= game.known - 1e-3;
    if (!game.number || (time === game.sent && !starved)) return;
    game.sent = time;
    link.send({ type: 'clock', game: game.number, time, latest: true });
  }, HEARD_MS);
}

/** The player that was clicked, or at whose feet the floor was. */
function playerAt(players, body, floor) {
  if (body && players.some(({ name }) => name === body.actor)) return body.actor;
  if (!floor) return null;
  const far = players.map(({ name, x, z }) => [Math.hypot(floor[0] - x, floor[2] - z), name]);
  const [least, name] = far.sort(([a], [b]) => a - b)[0] ?? [Infinity, null];
  return least < NEAR_METRES ? name : null;
}

/** Who passes to whom at a second, who is next, and where the ball has bounced of late. */
function stateAt({ passes, bounces, holder, picked, waits, known }, time) {
  let index = passes.length - 1;
  while (index >= 0 && passes[index].start > time) index -= 1;
  const pass = index >= 0 && time <= passes[index].stop + 1e-6 ? passes[index] : null;
  const last = passes[index - (pass ? 1 : 0)] ?? null;
  const later = passes[index + 1];
  const next = later ? later.to : holder;
  const newest = time >= known - 1.5;
  const marked = bounces.filter(([at]) => at <= time && at > time - 3).map(([, x, z]) => [x, z]);
  const then = !later || newest ? picked : [];
  const key = JSON.stringify([index, Boolean(pass), next, then, waits, marked.length, marked[0]]);
  return { pass, last, next, then, waits: waits && !later, marked, key };
}
