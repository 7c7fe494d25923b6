/** Throw: click on the body and a ball flies at it. */

import { savePanel } from '../save.js';
import { createLiveClock } from './throw/live_clock.js';
import { createOutcome } from './throw/outcome.js';
import { createSettings } from './throw/settings.js';
import { createStudy } from './throw/study.js';

const HINT = 'Click on the character: a ball flies at it along your line of sight.';
const FIRST = 'character0';

export function start({ stage, player, ui, side, link, options }) {
  const clock = createLiveClock(stage);
  const state = { aside: false };

  const main = ui.panel(side, 'Throw');
  const said = ui.sentence(main, 'outcome');
  said.set(HINT, 'plain');
  const buttons = ui.row(main);
  const ten = ui.button(buttons, { label: 'Throw ten', onClick: () => link.send({ type: 'ten' }) });
  ui.button(buttons, {
    label: 'Replay', title: 'The last throw again, in slow motion',
    onClick: () => replay(false),
  });
  ui.button(buttons, {
    label: 'Ghosts', title: 'The last throw with the other ways out, and why they were not taken',
    onClick: () => replay(true),
  });
  const back = ui.button(buttons, { label: 'Back to live', strong: true, onClick: goLive });
  back.hidden = true;
  const pace = ui.choice(main, {
    label: 'Time', name: 'pace', value: 1,
    options: [[0, 'Pause'], [0.25, '¼×'], [1, '1×'], [2, '2×']].map(([value, label]) => ({ value, label })),
    onChange: (value) => link.send({ type: 'pace', pace: value }),
  });
  const outcome = createOutcome(ui, ui.panel(side, 'Why'));
  const settings = createSettings({ ui, side, link, options });
  const study = createStudy({ ui, side, link, goLive });
  savePanel({ stage, player, ui, side, link, formats: options.formats });

  function replay(ghosts) {
    link.send({ type: 'replay', ghosts });
  }

  function goLive() {
    link.send({ type: 'live' });
  }

  function setAside(aside) {
    state.aside = aside;
    back.hidden = !aside;
    pace.element.hidden = aside;
    ten.disabled = aside;
    player.live = !aside;
    clock.running = !aside;
  }

  stage.onClick(({ x, y, body }) => {
    if (state.aside) return;
    const { from, to } = stage.ray(x, y);
    const message = { type: 'throw', from: [...from], to: [...to] };
    if (body) Object.assign(message, { place: [...body.place], lane: Number(body.actor.slice(-1)) });
    link.send(message);
  });

  link.on('show', ({ show }) => {
    setAside(true);
    stage.follow = null;
    stage.frameAll();
    player.speed = 0.25;
    player.play();
    stage.canvas.focus({ preventScroll: true }); // the keys are the player's now
    said.set(capital(show.words), 'plain');
    outcome.show(show);
  });
  link.on('sentence', ({ text, tone }) => said.set(text, tone));

  const notes = {
    scene({ show }) {
      setAside(false);
      stage.setShow(show);
      stage.follow = FIRST;
      if (!clock.known) stage.frameOn(FIRST);
      study.hide();
    },
    clock: ({ now, pace: running }) => clock.set(now, running),
    thrown({ lane }) {
      if (lane === 0) said.set('A ball is in the air.', 'busy');
    },
    found(note) {
      if (note.lane === 0) said.set(`It ${note.words}.`.replace('It no ', 'No '), 'busy');
      outcome.note(note);
    },
    answer(note) {
      if (note.lane === 0 && !state.aside) said.set(capital(note.words), note.tone);
      outcome.note(note);
    },
    series({ done, avoided, of }) {
      ten.disabled = done < of;
      ten.textContent = done < of ? `${avoided} of ${done} avoided …` : 'Throw ten';
      if (done === of) said.set(`${avoided} of ${of} avoided.`, avoided > of / 2 ? 'good' : 'plain');
    },
    trial: ({ letters }) => study.ask(letters),
    picked: (note) => study.picked(note),
  };
  link.on('note', (note) => notes[note.event]?.(note));
  settings.onSecond((on) => link.send({ type: 'second', on }));
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
