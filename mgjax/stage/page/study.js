/*
 * The page that leads an observer through the trials of a study. A classic script, so that it runs
 * from a folder; each trial is a page of its own in a frame. `study-payload` holds {format, study,
 * trials: [{page, letters}]}; what was picked is kept in the browser until it is saved.
 */
(() => {
  'use strict';
  const study = JSON.parse(document.getElementById('study-payload').textContent);
  const by = (id) => document.getElementById(id);
  const [view, name, picks, where, back, next, save] =
    ['view', 'observer', 'picks', 'where', 'back', 'next', 'save'].map(by);
  const place = `mgjax-study-${study.study}`;
  const state = { at: 0, observer: '', picked: {}, ...kept() };

  function kept() {
    try {
      return JSON.parse(localStorage.getItem(place) ?? '{}');
    } catch {
      return {};
    }
  }

  function keep() {
    try {
      localStorage.setItem(place, JSON.stringify(state));
    } catch { /* a browser that keeps nothing: the picks last as long as the page */ }
  }

  function pick(letter) {
    state.picked[state.at + 1] = { letter, when: new Date().toISOString() };
    draw();
  }

  function go(step) {
    state.at = Math.min(Math.max(state.at + step, 0), study.trials.length - 1);
    draw();
  }

  function draw() {
    keep();
    const { page, letters } = study.trials[state.at];
    if (view.getAttribute('src') !== page) view.setAttribute('src', page);
    const now = state.picked[state.at + 1]?.letter;
    picks.replaceChildren(...letters.map((letter) => {
      const button = document.createElement('button');
      button.textContent = letter;
      button.setAttribute('aria-pressed', String(letter === now));
      button.addEventListener('click', () => pick(letter));
      return button;
    }));
    const done = Object.keys(state.picked).length;
    where.textContent = `Trial ${state.at + 1} of ${study.trials.length}, ${done} picked`;
    back.disabled = state.at === 0;
    next.disabled = state.at === study.trials.length - 1;
    save.disabled = done === 0 || name.value.trim() === '';
    save.title = name.value.trim() === '' ? 'Say who you are first' : '';
  }

  function file() {
    const observer = name.value.trim();
    const lines = Object.entries(state.picked).map(([trial, { letter, when }]) => JSON.stringify({
      format: study.format, study: study.study, trial: Number(trial), observer, when, pick: letter,
    }));
    const link = document.createElement('a');
    link.href = URL.createObjectURL(new Blob([`${lines.join('\n')}\n`], { type: 'application/jsonl' }));
    link.download = `picks-${observer.replace(/[^\p{L}\p{N}]+/gu, '-').replace(/^-|-$/g, '')}.jsonl`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  name.value = state.observer;
  name.addEventListener('input', () => {
    state.observer = name.value;
    draw();
  });
  back.addEventListener('click', () => go(-1));
  next.addEventListener('click', () => go(1));
  save.addEventListener('click', file);
  draw();
})();
