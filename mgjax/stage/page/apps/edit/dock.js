/** The part under the player: one of several views, as low or as high as the person wants it. */

import { element } from '../../dom.js';

/**
 * @param {HTMLElement} parent
 * @param {string[]} names of the views
 * @param {(name: string) => void} onOpen
 */
export function createDock(parent, names, onOpen) {
  const tabs = new Map();
  const bar = element('div', { class: 'ed-tabs', role: 'tablist', 'aria-label': 'Under the picture' });
  const dock = element('section', { class: 'ed-dock', 'data-name': 'dock' }, bar);
  for (const name of names) {
    const tab = element('button', {
      type: 'button', class: 'ed-tab', role: 'tab', text: name, 'data-name': `tab-${name.toLowerCase()}`,
      on: { click: () => open(name) },
    });
    const tools = element('div', { class: 'ed-tools' });
    const body = element('div', { class: 'ed-body', role: 'tabpanel', 'aria-label': name });
    tabs.set(name, { tab, tools, body });
    bar.append(tab);
    dock.append(body);
  }
  for (const { tools } of tabs.values()) bar.append(tools);
  const tall = element('button', {
    type: 'button', class: 'mg-button mg-icon', text: '⤢', title: 'Higher or lower', 'data-name': 'dock-height',
    'aria-label': 'Higher or lower', on: { click: () => dock.classList.toggle('ed-tall') },
  });
  bar.append(tall);
  parent.append(dock);

  function open(name) {
    for (const [each, { tab, tools, body }] of tabs) {
      tab.setAttribute('aria-selected', String(each === name));
      tools.hidden = each !== name;
      body.hidden = each !== name;
    }
    dock.dataset.tab = name;
    onOpen(name);
  }

  return { element: dock, open, part: (name) => tabs.get(name) };
}

/** Buttons that zoom a picture: out, all of it, in. */
export function zoomButtons(ui, parent, name, picture) {
  const icon = (label, key, title, onClick) => {
    const made = ui.button(parent, { label, name: `${name}-${key}`, title, onClick });
    made.classList.add('mg-icon');
    made.setAttribute('aria-label', title);
  };
  icon('−', 'out', 'Zoom out (Ctrl and wheel)', () => picture.zoom(1 / 1.5));
  icon('⇔', 'fit', 'All of it', () => picture.fit());
  icon('+', 'in', 'Zoom in (Ctrl and wheel)', () => picture.zoom(1.5));
}
