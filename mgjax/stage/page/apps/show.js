/** Show: a result as it was written, with its words. */

import { showInfo } from '../info.js';
import { savePanel } from '../save.js';

export function start({ stage, player, ui, side, link, options }) {
  player.live = false;
  link.on('show', ({ show }) => {
    side.replaceChildren();
    showInfo(side, show);
    savePanel({ stage, player, ui, side, link, formats: options.formats });
    stage.frameAll();
    player.play();
  });
}
