/** What was found, on the stage: who walks, the path and its track, things and marks. */

const NEARER = 0.8;
const KINDS = ['actors', 'lines', 'things'];

/** Shows notes of the server; the walk goes on playing where it was, a new one from its beginning. */
export function createPicture({ stage, player }) {
  const shown = { actors: ['waiting'], lines: [], things: [] };
  const walked = () => shown.actors.includes('walker');

  function replace(kind, items) {
    const ids = items.map(({ id }) => id);
    for (const id of shown[kind]) if (!ids.includes(id)) stage.remove(kind, id);
    for (const item of items) stage.put(kind, item);
    shown[kind] = ids;
  }

  return {
    show(note) {
      const before = { time: player.time, walked: walked(), playing: player.playing };
      for (const kind of KINDS) replace(kind, note[kind]);
      player.setShow(note);
      if (!walked()) {
        player.pause();
        return;
      }
      const anew = note.fresh || !before.walked;
      player.seek(anew ? 0 : before.time);
      if (anew) player.play();
      if (note.fresh === 'given') {
        stage.frameAll();
        stage.camera.zoom(NEARER);
        stage.wake();
      }
    },
  };
}
