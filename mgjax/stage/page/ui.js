/**
 * Building blocks of panels: each is appended to `parent`, can be used by keyboard, has a label and
 * a stable `data-name` (from its label, or `name`).
 */

import { element, freshId, nameOf, readable } from './dom.js';
import { icon } from './icons.js';
import { PALETTE } from './look.js';

/** A part of the side with a title; returns the element that takes its content. */
export function panel(parent, title, { open = true } = {}) {
  const body = element('div', { class: 'mg-panel-body' });
  const heading = element('summary', { class: 'mg-panel-title', text: title });
  parent.append(element('details', { class: 'mg-panel', open, 'data-name': nameOf(title) }, heading, body));
  return body;
}

/**
 * A number by a slider; `onInput` while it moves, `onChange` when it is let go.
 * @returns {{value: number, element: HTMLElement, disabled: boolean}} `value` may be set
 */
export function slider(parent, { label, name, unit = '', min, max, step, value, onInput, onChange }) {
  const id = freshId();
  const shown = element('output', { class: 'mg-value', for: id });
  const input = element('input', {
    type: 'range', id, min, max, step, 'data-name': name ?? nameOf(label),
    on: {
      input() { show(); onInput?.(Number(input.value)); },
      change() { onChange?.(Number(input.value)); },
    },
  });
  input.value = value;
  const row = element('div', { class: 'mg-slider' },
    element('label', { for: id, text: label }), shown, input);
  parent.append(row);
  function show() {
    shown.textContent = `${readable(Number(input.value))}${unit ? ` ${unit}` : ''}`;
    input.setAttribute('aria-valuetext', shown.textContent);
  }
  show();
  return {
    element: row,
    get value() { return Number(input.value); },
    set value(next) { input.value = next; show(); },
    get disabled() { return input.disabled; },
    set disabled(next) { input.disabled = next; },
  };
}

/** @returns {HTMLButtonElement} */
export function button(parent, { label, name, title, strong = false, onClick }) {
  const made = element('button', {
    type: 'button', class: strong ? 'mg-button mg-strong' : 'mg-button', text: label, title,
    'data-name': name ?? nameOf(label), on: { click: onClick },
  });
  parent.append(made);
  return made;
}

/** A small button with a picture of icons.js; `title` says what it does. */
export function iconButton(parent, { picture, name = picture, title, onClick }) {
  const made = element('button', {
    type: 'button', class: 'mg-button mg-icon', title, 'aria-label': title, 'data-name': name,
    on: { click: onClick },
  }, icon(picture));
  parent.append(made);
  return made;
}

/** A row in which buttons stand side by side. */
export function row(parent) {
  const made = element('div', { class: 'mg-row' });
  parent.append(made);
  return made;
}

/** One of several: buttons side by side up to four, a list above. `value` may be set. */
export function choice(parent, { label, name, options, value, onChange }) {
  const key = name ?? nameOf(label);
  return options.length <= 4
    ? segments(parent, { label, key, options, value, onChange })
    : menu(parent, { label, key, options, value, onChange });
}

function segments(parent, { label, key, options, value, onChange }) {
  const group = freshId();
  const inputs = options.map((option) => element('input', {
    type: 'radio', name: group, id: freshId(), value: option.value, checked: option.value === value,
    'data-name': `${key}-${nameOf(String(option.value))}`,
    on: { change: () => onChange?.(option.value) },
  }));
  const parts = inputs.flatMap((input, i) => (
    [input, element('label', { for: input.id, text: options[i].label })]));
  const box = element('div', { class: 'mg-segments', role: 'radiogroup', 'aria-label': label, 'data-name': key },
    ...parts);
  const whole = element('div', { class: 'mg-choice' },
    element('span', { class: 'mg-label', text: label }), box);
  parent.append(whole);
  return {
    element: whole,
    get value() { return options[inputs.findIndex((input) => input.checked)]?.value; },
    set value(next) { inputs.forEach((input, i) => { input.checked = options[i].value === next; }); },
  };
}

function menu(parent, { label, key, options, value, onChange }) {
  const id = freshId();
  const select = element('select', {
    id, 'data-name': key,
    on: { change: () => onChange?.(options[select.selectedIndex].value) },
  }, ...options.map((option) => element('option', { text: option.label, value: option.value })));
  select.selectedIndex = options.findIndex((option) => option.value === value);
  const whole = element('div', { class: 'mg-choice' },
    element('label', { class: 'mg-label', for: id, text: label }), select);
  parent.append(whole);
  return {
    element: whole,
    get value() { return options[select.selectedIndex]?.value; },
    set value(next) {
      select.selectedIndex = options.findIndex((option) => option.value === next);
    },
  };
}

/** On or off; `value` may be set. */
export function toggle(parent, { label, name, title, value = false, onChange }) {
  const id = freshId();
  const input = element('input', {
    type: 'checkbox', id, checked: value, 'data-name': name ?? nameOf(label), role: 'switch',
    on: { change: () => onChange?.(input.checked) },
  });
  const whole = element('div', { class: 'mg-toggle', title }, input, element('label', { for: id, text: label }));
  parent.append(whole);
  return {
    element: whole,
    get value() { return input.checked; },
    set value(next) { input.checked = next; },
  };
}

/** One sentence that says what came of it; read aloud when it changes. */
export function sentence(parent, name = 'sentence') {
  const made = element('p', { class: 'mg-sentence', role: 'status', 'data-name': name });
  parent.append(made);
  return {
    element: made,
    /** @param {'good' | 'bad' | 'plain' | 'busy'} tone */
    set(text, tone = 'plain') {
      made.textContent = text;
      made.dataset.tone = tone;
      made.hidden = !text;
    },
  };
}

/** Numbers as bars: set([{name, value, of, colour}]). */
export function bars(parent, name = 'bars') {
  const made = element('div', { class: 'mg-bars', role: 'list', 'data-name': name });
  parent.append(made);
  return {
    element: made,
    set(items) {
      made.replaceChildren(...items.map(({ name: text, value, of = 1, colour = 'blue' }) => {
        const fill = element('i');
        fill.style.width = `${100 * Math.min(1, Math.max(0, of > 0 ? value / of : 0))}%`;
        fill.style.background = PALETTE[colour] ?? PALETTE.grey;
        return element('div', { class: 'mg-bar', role: 'listitem', title: `${text}: ${readable(value)}` },
          element('span', { text }), element('b', {}, fill), element('span', { text: readable(value) }));
      }));
    },
  };
}

/** Names and values: set([[name, value], …]). */
export function table(parent, name = 'table') {
  const made = element('dl', { class: 'mg-table', 'data-name': name });
  parent.append(made);
  return {
    element: made,
    set(items) {
      made.replaceChildren(...items.flatMap(([key, value]) => (
        [element('dt', { text: key }), element('dd', { text: String(value) })])));
    },
  };
}

/** Entries of which one is picked: set([{id, label, detail, picture}], onPick); `picked` an id. */
export function list(parent, name = 'list') {
  const made = element('div', { class: 'mg-list', 'data-name': name });
  parent.append(made);
  const handle = {
    element: made,
    set(items, onPick, empty = '') {
      made.replaceChildren(...items.map(({ id, label, detail, picture }) => element('button', {
        type: 'button', class: 'mg-entry', 'data-id': id,
        on: { click() { handle.picked = id; onPick?.(id); } },
      }, ...(picture ? [element('img', { src: picture, alt: '' })] : []),
      element('span', { class: 'mg-entry-label', text: label }),
      element('span', { class: 'mg-entry-detail', text: detail ?? '' }))));
      if (!items.length && empty) made.append(element('p', { class: 'mg-empty', text: empty }));
    },
    set picked(id) {
      for (const entry of made.querySelectorAll('.mg-entry')) {
        entry.setAttribute('aria-pressed', String(entry.dataset.id === String(id)));
      }
    },
  };
  return handle;
}

/** How much is done: set(share 0 … 1, text); hidden at 1. */
export function progress(parent, name = 'progress') {
  const text = element('span');
  const meter = element('progress', { max: 1, value: 0 });
  const made = element('div', { class: 'mg-progress', hidden: true, 'data-name': name }, text, meter);
  parent.append(made);
  return {
    element: made,
    set(share, words = '') {
      meter.value = share;
      text.textContent = words;
      made.hidden = share >= 1;
    },
  };
}

/** A file of the person's: `onText(text, name)` or `onBytes(Uint8Array, name)`. */
export function fileButton(parent, { label, name, accept, onText, onBytes }) {
  const input = element('input', {
    type: 'file', accept, hidden: true, 'data-name': `${name ?? nameOf(label)}-file`,
    on: {
      async change() {
        const [file] = input.files;
        input.value = '';
        if (!file) return;
        if (onBytes) onBytes(new Uint8Array(await file.arrayBuffer()), file.name);
        else onText(await file.text(), file.name);
      },
    },
  });
  parent.append(input);
  return button(parent, { label, name, onClick: () => input.click() });
}

/** Saves bytes or text as a file of the person's. */
export function download(name, data, mime = 'application/octet-stream') {
  const url = URL.createObjectURL(new Blob([data], { type: mime }));
  const link = element('a', { href: url, download: name, hidden: true });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** Whether the page is dark: as the person's system wants it. */
export const systemDark = () => matchMedia('(prefers-color-scheme: dark)').matches;

/** Makes page and stage dark or light. */
export function setDark(stage, dark) {
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
  if (stage) stage.dark = dark;
}

/** A button that changes between light and dark. */
export function themeButton(parent, stage) {
  return iconButton(parent, {
    picture: 'theme', title: 'Light or dark', onClick: () => setDark(stage, !stage.dark),
  });
}
