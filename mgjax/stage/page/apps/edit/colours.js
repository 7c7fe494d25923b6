/** The colour of each kind of label, the same everywhere and after every reload. */

import { PALETTE } from '../../look.js';

const KNOWN = {
  duck: 'blue', sway: 'orange', jump: 'green', twist: 'purple', sidestep: 'sky', crouch: 'red', lean_back: 'yellow',
};
const OTHERS = ['green', 'purple', 'sky', 'orange', 'red', 'blue'];

/** A colour of the palette for a kind; kinds that are not known get one by their letters. */
export function kindColour(kind) {
  if (Object.hasOwn(KNOWN, kind)) return PALETTE[KNOWN[kind]];
  let sum = 0;
  for (const letter of kind) sum = (sum * 31 + letter.codePointAt(0)) % 9973;
  return PALETTE[OTHERS[sum % OTHERS.length]];
}

/** From near to far: the colours of transitions. */
export const NEAR_TO_FAR = [PALETTE.blue, PALETTE.sky, PALETTE.green, PALETTE.orange, PALETTE.red];

/** A colour between two of the form #rrggbb. */
export function between(from, to, share) {
  const parts = [1, 3, 5].map((at) => {
    const [a, b] = [from, to].map((code) => parseInt(code.slice(at, at + 2), 16));
    return Math.round(a + (b - a) * share).toString(16).padStart(2, '0');
  });
  return `#${parts.join('')}`;
}

/** What a page's colour is now, light or dark: `--text`, `--quiet`, … */
export const themed = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** What a label is, in a few words. */
export function labelWords({ kind, direction, genuine }) {
  return [kind, direction && `to the ${direction}`, genuine ? '' : '(exercise)'].filter(Boolean).join(' ');
}
