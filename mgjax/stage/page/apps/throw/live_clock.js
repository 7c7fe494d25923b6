/** The time of the scene that the server plays, a little behind it. */

const BEHIND = 0.05;
const CATCH_UP = 0.1;

/** Sets the stage's time before each frame while it runs. */
export function createLiveClock(stage) {
  const state = { at: null, since: 0, pace: 1, running: true, shown: null };

  function now() {
    return state.at + ((performance.now() - state.since) / 1000) * state.pace;
  }

  stage.onTick(() => {
    if (!state.running || state.at === null) return false;
    stage.time = Math.max(0, now() - BEHIND);
    return state.pace > 0;
  });

  return {
    get known() { return state.at !== null; },
    get running() { return state.running; },
    set running(value) {
      state.running = value;
      stage.wake();
    },
    /** The server's time and pace; small differences are taken up little by little. */
    set(time, pace) {
      const off = state.at === null || pace !== state.pace ? Infinity : time - now();
      const next = Math.abs(off) > 0.25 ? time : now() + CATCH_UP * off;
      Object.assign(state, { at: next, since: performance.now(), pace });
      stage.wake();
    },
  };
}
