/** The panel of a match: what happens now, how the next passes are made, the user's body. */

const KINDS = [
  { value: 'any', label: 'any' }, { value: 'toss', label: 'toss' },
  { value: 'pass', label: 'pass' }, { value: 'attack', label: 'attack' },
];
const BOUNCES = [
  { value: 'any', label: 'any' }, { value: '0', label: '0' }, { value: '1', label: '1' },
  { value: '2', label: '2' },
];
const COUNTS = [{ value: 3, label: '3' }, { value: 6, label: '6' }];

/**
 * Fills the side.
 * @param {object} ui of ui.js
 * @param {HTMLElement} side
 * @param {{pick(name: string): void, send(message: object): void}} asks
 */
export function createSide(ui, side, { pick, send }) {
  const settings = { kind: 'any', bounces: 'any', on: true, players: 3, net: true };
  const happens = ui.sentence(side, 'now');
  const trouble = ui.sentence(side, 'trouble-here');
  trouble.set('');

  const next = ui.panel(side, 'Next pass');
  const names = ui.row(next);
  names.dataset.name = 'players';
  const wish = (change) => {
    Object.assign(settings, change);
    const { kind, bounces, on } = settings;
    send({ type: 'wish', kind, bounces, on });
  };
  const kind = ui.choice(next, {
    label: 'Kind', options: KINDS, value: 'any', onChange: (value) => wish({ kind: value }),
  });
  const bounces = ui.choice(next, {
    label: 'Bounces', options: BOUNCES, value: 'any', onChange: (value) => wish({ bounces: value }),
  });
  const on = ui.toggle(next, {
    label: 'Play on by itself', name: 'on', value: true,
    title: 'Off: whoever has the ball waits until you say who gets it',
    onChange: (value) => wish({ on: value }),
  });
  const back = ui.button(next, {
    label: 'Take back the last click', name: 'unpick', onClick: () => send({ type: 'unpick' }),
  });

  const far = ui.panel(side, 'So far');
  const last = ui.sentence(far, 'last-pass');
  last.set('');
  const table = ui.table(far, 'figures');
  const save = ui.row(far);
  ui.button(save, {
    label: 'Save files', name: 'save-zip', title: 'BVH of each player, the ball’s path, the timeline',
    onClick: () => send({ type: 'export', what: 'zip' }),
  });
  ui.button(save, {
    label: 'Save as a page', name: 'save-html', title: 'One file that plays in any browser',
    onClick: () => send({ type: 'export', what: 'html' }),
  });

  const you = ui.panel(side, 'You as a player');
  const said = ui.sentence(you, 'user');
  said.set('Your kick before a motion sensor, or a clip’s, decides how the next pass is made.');
  const sensor = ui.toggle(you, {
    label: 'Motion sensor (VMC)', name: 'sensor', onChange: (value) => send({ type: 'sensor', on: value }),
  });
  const clips = document.createElement('div');
  you.append(clips);

  const pitch = ui.panel(side, 'Pitch');
  const again = () => send({ type: 'pitch', players: settings.players, net: settings.net });
  const count = ui.choice(pitch, {
    label: 'Players', name: 'count', options: COUNTS, value: 3,
    onChange: (value) => { settings.players = value; again(); },
  });
  const net = ui.toggle(pitch, {
    label: 'Net', value: true, onChange: (value) => { settings.net = value; again(); },
  });
  ui.button(pitch, { label: 'Begin again', name: 'reset', onClick: again });

  return {
    /** A new match. */
    begin({ players, net: hasNet, clips: known }) {
      Object.assign(settings, { players: players.length, net: hasNet });
      count.value = players.length;
      net.value = hasNet;
      sensor.value = false;
      trouble.set('');
      names.replaceChildren();
      for (const { name } of players) {
        ui.button(names, {
          label: name, name: `pick-${name.toLowerCase()}`, title: `${name} gets the ball next`,
          onClick: () => pick(name),
        });
      }
      if (!clips.childElementCount) clipMenu(known);
    },
    table: (rows) => table.set(rows.length ? rows : [['passes made', '0']]),
    wishes(told) {
      Object.assign(settings, { kind: told.kind, bounces: told.bounces, on: told.on });
      [kind.value, bounces.value, on.value] = [told.kind, told.bounces, told.on];
      back.disabled = !told.picked.length;
      trouble.set('');
    },
    user: (text, tone) => said.set(capital(text), tone),
    busy: (text) => happens.set(`${text} …`, 'busy'),
    trouble: (text, tone) => trouble.set(capital(text), tone),
    now(state, game) {
      const { text, tone } = nowWords(state, game);
      happens.set(text, tone);
      last.set(state.last ? `${capital(state.last.words)}.` : '', state.last?.tone);
    },
  };

  function clipMenu(known) {
    let chosen = known[0];
    ui.choice(clips, {
      label: 'A clip as you', name: 'clip', value: chosen,
      options: known.map((name) => ({ value: name, label: name })),
      onChange: (value) => { chosen = value; },
    });
    ui.button(clips, {
      label: 'Play it', name: 'replay', onClick: () => send({ type: 'replay', clip: chosen }),
    });
  }
}

const capital = (text) => (text ? text[0].toUpperCase() + text.slice(1) : '');

/** What happens now, and what a click would do. */
function nowWords({ pass, next, then, waits }, { picked }) {
  if (waits) {
    return { text: `${next} waits. Click who gets the ball.`, tone: 'busy' };
  }
  const parts = [];
  if (pass?.to) {
    parts.push(pass.by ? `${pass.by} passes to ${pass.to} (${pass.kind})` : `The ball is thrown in to ${pass.to}`);
  }
  if (!pass) parts.push('The ball is about to be thrown in');
  const order = [pass?.to, next, ...then].filter((name, k, all) => name && name !== all[k - 1]);
  if (order.length > 1) parts.push(`then to ${order.slice(1).join(', ')}`);
  const whose = picked.length ? picked[picked.length - 1] : next;
  return { text: `${parts.join(', ')}. Click who gets it from ${whose}.`, tone: 'plain' };
}
