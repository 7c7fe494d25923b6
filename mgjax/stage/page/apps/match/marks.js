/** What is drawn on the floor: who gets the ball, who gets it then, and where it has bounced. */

const RING = 0.55;
const BOUNCE = 0.13;
const MOST_BOUNCES = 4;
const GAP = 0.65;
/** Arrows keep to one side, so that there and back stay apart, m. */
const ASIDE = 0.12;

/** Marks on a stage. */
export function createMarks(stage) {
  const there = new Set();

  function ring(id, { x, z }, colour, note = '', radius = RING) {
    there.add(id);
    stage.put('things', { id, shape: 'ring', place: [x, 0, z], radius, colour, note });
  }

  function arrow(id, from, to, colour, dashed) {
    const [dx, dz] = [to.x - from.x, to.z - from.z];
    const far = Math.hypot(dx, dz);
    if (far <= 2 * GAP) return;
    const [sx, sz] = [dx / far, dz / far];
    const at = (way) => [from.x + sx * way - sz * ASIDE, 0, from.z + sz * way + sx * ASIDE];
    const [hx, , hz] = at(far - GAP);
    const wing = (side) => [hx - 0.22 * sx + side * 0.13 * sz, 0, hz - 0.22 * sz - side * 0.13 * sx];
    const line = (name, places, dash) => {
      there.add(`line ${name}`);
      stage.put('lines', {
        id: name, points: new Float32Array(places.flat()), colour, width: 3, dashed: dash,
      });
    };
    line(id, [at(GAP), at(far - GAP)], dashed);
    line(`${id} head`, [wing(1), at(far - GAP), wing(-1)], false);
  }

  function clear() {
    for (const id of there) {
      if (id.startsWith('line ')) stage.remove('lines', id.slice(5));
      else stage.remove('things', id);
    }
    there.clear();
  }

  return {
    /** @param state of match.js `stateAt` */
    set({ pass, next, then, marked, waits }, players) {
      clear();
      const at = Object.fromEntries(players.map((player) => [player.name, player]));
      const receiver = pass?.to || '';
      if (receiver) ring('receiver', at[receiver], 'orange');
      if (pass?.by && receiver) arrow('now', at[pass.by], at[receiver], 'orange', false);
      if (next && next !== receiver) {
        ring('next', at[next], 'sky');
        if (receiver && !waits) arrow('next', at[receiver], at[next], 'sky', true);
      }
      then.reduce((from, to, k) => {
        if (from !== to) arrow(`then ${k}`, at[from], at[to], 'grey', true);
        return to;
      }, next);
      marked.slice(-MOST_BOUNCES).forEach(([x, z], k) => (
        ring(`bounce ${k}`, { x, z }, 'orange', '', BOUNCE)));
    },
  };
}
