/** Drawing on the floor: the line is there while it is drawn. */

const STEP = 0.02;
const LINE = 'pen';
const MOST = 4000;

/**
 * @param {object} stage
 * @param {(points: number[][]) => void} onStroke [x, z] of a stroke that is done, m
 * @returns {{lift(): void}} takes the line away
 */
export function createPen(stage, onStroke) {
  let points = [];

  function add([x, , z]) {
    const last = points[points.length - 1];
    if (last && Math.hypot(x - last[0], z - last[1]) < STEP) return;
    if (points.length < MOST) points.push([x, z]);
  }

  stage.onFloorDrag(({ phase, point }) => {
    if (phase === 'start') points = [];
    add(point);
    if (points.length > 1) {
      const flat = new Float32Array(points.flatMap(([x, z]) => [x, 0, z]));
      stage.put('lines', { id: LINE, points: flat, colour: 'orange', width: 6 });
    }
    if (phase !== 'end') return;
    if (points.length > 1) onStroke(points);
    points = [];
  });
  return { lift: () => { if (!points.length) stage.remove('lines', LINE); } };
}
