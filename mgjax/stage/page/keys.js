/** Which of several players on a page the keyboard belongs to. */

const players = new Set();
let hovered = null;

/**
 * Hears keys for one player: those pressed in one of its elements, else under the mouse, else where
 * it is the only one.
 * @param {HTMLElement[]} elements
 * @param {(event: KeyboardEvent) => boolean} onKey whether the key was used
 * @returns {() => void} stop
 */
export function hearKeys(elements, onKey) {
  const player = { elements, onKey };
  const enter = () => { hovered = player; };
  const leave = () => { if (hovered === player) hovered = null; };
  players.add(player);
  if (players.size === 1) document.addEventListener('keydown', deal);
  for (const each of elements) {
    each.addEventListener('pointerenter', enter);
    each.addEventListener('pointerleave', leave);
  }
  return () => {
    players.delete(player);
    leave();
    if (!players.size) document.removeEventListener('keydown', deal);
    for (const each of elements) {
      each.removeEventListener('pointerenter', enter);
      each.removeEventListener('pointerleave', leave);
    }
  };
}

/** Keys that the focused control needs itself. */
function needed(event) {
  const { tagName, type } = event.target;
  if (event.ctrlKey || event.metaKey || event.altKey) return true;
  if (tagName === 'TEXTAREA' || tagName === 'SELECT') return true;
  if (tagName === 'BUTTON' || tagName === 'SUMMARY') return event.key === ' ' || event.key === 'Enter';
  if (tagName !== 'INPUT') return event.target.isContentEditable;
  return !event.target.classList.contains('mg-scrub') && type !== 'button';
}

function deal(event) {
  if (event.defaultPrevented || needed(event)) return;
  const focused = [...players].find(({ elements }) => elements.some((each) => each.contains(event.target)));
  const player = focused ?? hovered ?? (players.size === 1 ? [...players][0] : null);
  if (player?.onKey(event)) event.preventDefault();
}
