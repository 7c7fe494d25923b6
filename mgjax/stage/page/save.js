/** Saving what is seen: as a picture, a film, a page of its own, or a motion. */

const RATE = 30;

/**
 * A panel with which what is seen is saved.
 * @param {string[]} formats what the application writes, such as 'html' and 'bvh'
 */
export function savePanel({ stage, player, ui, side, link, formats }) {
  const panel = ui.panel(side, 'Export', { open: false });
  const row = ui.row(panel);
  const said = ui.sentence(panel, 'saving');
  said.set('');
  const state = { filming: false };

  ui.button(row, { label: 'Picture', onClick: savePicture });
  const film = ui.button(row, {
    label: 'Film', title: 'Of what the bar under the picture plays', onClick: saveFilm,
  });
  for (const format of formats.filter((each) => each === 'html')) ask(row, format, 'Page');
  const motions = formats.filter((each) => each !== 'html');
  if (motions.length) {
    const which = ui.choice(panel, {
      label: 'Motion as', name: 'motion-format', value: motions[0],
      options: motions.map((value) => ({ value, label: value })),
    });
    ui.button(panel, {
      label: 'Motion', onClick: () => link.send({ type: 'export', format: which.value }),
    });
  }

  function ask(parent, format, label) {
    ui.button(parent, { label, onClick: () => link.send({ type: 'export', format }) });
  }

  function savePicture() {
    const url = stage.snapshot();
    if (!url) return;
    const bytes = Uint8Array.from(atob(url.split(',')[1]), (each) => each.charCodeAt(0));
    ui.download('picture.png', bytes, 'image/png');
  }

  /** Draws every frame and sends it; the next one when the one before has arrived. */
  function saveFilm() {
    if (state.filming) return;
    if (player.live || !(player.seconds > player.begin)) {
      said.set('A film is made of what the bar under the picture plays: replay something first.');
      return;
    }
    player.pause();
    Object.assign(state, { filming: true, frames: Math.floor((player.seconds - player.begin) * RATE) + 1, begin: player.begin });
    film.disabled = true;
    sendFrame(0);
  }

  async function sendFrame(frame) {
    const data = await asJpeg(stage.snapshot(state.begin + frame / RATE));
    said.set(`Frame ${frame + 1} of ${state.frames}.`, 'busy');
    link.send({ type: 'film', frame, frames: state.frames, rate: RATE, data });
  }

  function done(words, tone) {
    state.filming = false;
    film.disabled = false;
    said.set(words, tone);
  }

  link.on('filmed', ({ frame }) => {
    if (!state.filming) return;
    if (frame + 1 < state.frames) sendFrame(frame + 1);
    else done('The film is saved.', 'good');
  });
  link.on('sentence', ({ text, tone }) => {
    if (state.filming) done(text, tone);
  });
}

/** A picture as a JPEG in a data URL. */
async function asJpeg(url) {
  const picture = new Image();
  picture.src = url;
  await picture.decode();
  const sheet = document.createElement('canvas');
  Object.assign(sheet, { width: picture.width, height: picture.height });
  sheet.getContext('2d').drawImage(picture, 0, 0);
  return sheet.toDataURL('image/jpeg', 0.92);
}
