/** How finely is drawn: measured times between frames decide, so that slow machines keep up. */

/** From best to plainest: pixels drawn for one of the page, shadow map, its taps, samples. */
export const LEVELS = [
  { scale: 1, shadow: 2048, taps: 9, samples: 4 },
  { scale: 1, shadow: 1024, taps: 9, samples: 0 },
  { scale: 0.75, shadow: 1024, taps: 1, samples: 0 },
  { scale: 0.6, shadow: 512, taps: 1, samples: 0 },
  { scale: 0.5, shadow: 0, taps: 0, samples: 0 },
];

const SLOW = 55;
const QUICK = 24;
const ENOUGH = 8;
const PATIENT = 90;
const HELPED = 0.92;
const HELD = 240;
const BREAK = 600;

/** The level to begin with: a processor that draws by itself cannot have the best. */
export function firstLevel(gl) {
  const names = gl.getExtension('WEBGL_debug_renderer_info');
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  return /swiftshader|llvmpipe|software/i.test(name) ? 1 : 0;
}

/** Watches frames and chooses a level. */
export function createQuality(level = 0) {
  let last = null;
  let times = [];
  let patience = PATIENT;
  let before = 0;
  let held = 0;
  let fixed = false;
  const quality = {
    level,
    ms: 0,

    /** Stays at a level; null: chooses again. */
    fix(level) {
      fixed = level !== null;
      if (fixed) quality.level = Math.min(LEVELS.length - 1, Math.max(0, level));
      times = [];
    },

    get now() { return LEVELS[quality.level]; },

    /**
     * A frame that was drawn at `now` (ms).
     * @param {boolean} running the one before it was drawn, too, so the time between the two tells
     *   how long drawing takes
     * @returns {boolean} whether the level has changed
     */
    frame(now, running) {
      const spent = last === null ? 0 : now - last;
      last = now;
      if (!running || spent > BREAK || spent <= 0) return false;
      quality.ms = quality.ms ? quality.ms * 0.9 + spent * 0.1 : spent;
      if (fixed) return false;
      times.push(spent);
      held = Math.max(0, held - 1);
      if (times.length >= ENOUGH) {
        const usual = median(times.slice(-ENOUGH));
        if (before && times.length === ENOUGH && usual > HELPED * before) return quality.undo();
        if (usual > SLOW && !held) return quality.plainer(usual);
      }
      if (times.length >= patience && median(times.slice(-patience)) < QUICK) return quality.move(-1);
      if (times.length > 2 * patience) times = times.slice(-patience);
      return false;
    },

    /** To a plainer level, because frames usually take so many ms; it will wait longer to go back. */
    plainer(usual) {
      patience = Math.min(1800, patience * 2);
      const moved = quality.move(1);
      before = moved ? usual : 0;
      return moved;
    },

    /** The plainer level was no quicker: something else is slow, and what is seen is not worse for it. */
    undo() {
      held = HELD;
      return quality.move(-1);
    },

    move(by) {
      const next = Math.min(LEVELS.length - 1, Math.max(0, quality.level + by));
      [times, before] = [[], 0];
      if (next === quality.level) return false;
      quality.level = next;
      return true;
    },
  };
  return quality;
}

function median(values) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[sorted.length >> 1];
}
