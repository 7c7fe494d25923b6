/** What a show says: its title, its sentence, figures and bars. */

import { element } from './dom.js';
import * as ui from './ui.js';

/**
 * Appends the words of a show to an element.
 * @param {HTMLElement} parent
 * @param {object} show types.py `Show`
 * @param {{open?: boolean}} options whether bars and figures are open at first
 * @returns {boolean} whether there was anything to say
 */
export function showInfo(parent, { title = '', words = '', notes = [], bars = [] }, { open = true } = {}) {
  if (title) parent.append(element('h1', { class: 'mg-title', text: title }));
  if (words) ui.sentence(parent, 'words').set(words);
  if (bars.length || notes.length) {
    const body = ui.panel(parent, 'Figures', { open });
    if (bars.length) ui.bars(body).set(bars);
    if (notes.length) ui.table(body, 'notes').set(notes);
  }
  return Boolean(title || words || notes.length || bars.length);
}
