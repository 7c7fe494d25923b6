/** What a show says: its title, its sentence, figures and bars. */

import { element } from './dom.js';
import * as ui from './ui.js';

/** Appends the words of a show to an element; returns whether there was anything to say. */
export function showInfo(parent, { title = '', words = '', notes = [], bars = [] }) {
  if (title) parent.append(element('h1', { class: 'mg-title', text: title }));
  if (words) ui.sentence(parent, 'words').set(words);
  if (bars.length) ui.bars(parent).set(bars);
  if (notes.length) ui.table(parent, 'notes').set(notes);
  return Boolean(title || words || notes.length || bars.length);
}
