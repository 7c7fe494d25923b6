/** Show: a result as it was written, with its words. */

import { showInfo } from '../info.js';

export function start({ stage, player, side, link }) {
  player.live = false;
  link.on('show', ({ show }) => {
    side.replaceChildren();
    showInfo(side, show);
    stage.frameAll();
    player.play();
  });
}
