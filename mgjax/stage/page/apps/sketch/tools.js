/** What a click or a drag on the floor does. */

import { element } from '../../dom.js';

const TOOLS = [
  ['draw', 'Draw', 'Drag on the floor: the path to walk along'],
  ['right_hand', 'Right hand', 'Click on the floor: something for the right hand'],
  ['left_hand', 'Left hand', 'Click on the floor: something for the left hand'],
  ['head', 'Head', 'Click on the floor: a place for the head'],
  ['bar', 'Bar', 'Click on the floor: a bar across the path, to duck under'],
  ['obstacle', 'Obstacle', 'Click on the floor: something to walk around'],
  ['select', 'Select', 'Click on a thing; a drag turns the view'],
];

/**
 * @returns {{body: HTMLElement, tool: string, places: boolean, pick(tool)}} places: a click on the
 * floor puts something there
 */
export function createTools({ ui, side, onTool }) {
  const body = ui.panel(side, 'Tools');
  const row = ui.row(body);
  const hint = element('p', { class: 'mg-empty', 'data-name': 'hint' });
  body.append(hint);
  const buttons = new Map(TOOLS.map(([tool, label, title]) => [tool, ui.button(row, {
    label, title, name: `tool-${tool.replace('_', '-')}`, onClick: () => tools.pick(tool),
  })]));
  const tools = {
    body,
    tool: 'draw',
    get places() { return tools.tool !== 'draw' && tools.tool !== 'select'; },
    pick(tool) {
      tools.tool = tool;
      for (const [name, button] of buttons) button.setAttribute('aria-pressed', String(name === tool));
      hint.textContent = `${TOOLS.find(([name]) => name === tool)[2]}.`;
      onTool(tool);
    },
  };
  return tools;
}
