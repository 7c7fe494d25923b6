/** Sliders and switches: of the ball, and of the search of either character. */

const BALL = [
  ['speed', 'Speed', 'm/s', 0.5],
  ['radius', 'Radius', 'm', 0.01],
  ['gravity', 'Gravity', 'm/s²', 0.1],
  ['notice', 'In the air for', 's', 0.05],
];
const SEARCH = [
  ['T_window', 'Window T', 's', 0.05],
  ['E_avoidance', 'E, avoidance', 'm·s', 0.0005],
  ['D_body', 'D, clearance', 'm', 0.01],
  ['w_a', 'Weight: avoidance', '', 0.05],
  ['w_b', 'Weight: body', '', 0.05],
  ['w_m', 'Weight: movement', '', 0.05],
  ['w_t', 'Weight: time scale', '', 0.05],
];

export function createSettings({ ui, side, link, options }) {
  const heard = [];
  const values = [{ ...options.settings }, { ...options.settings }];
  let lane = 0;
  const ball = ui.panel(side, 'Ball');
  BALL.forEach((row) => add(ball, row));
  const search = ui.panel(side, 'Search', { open: false });
  const who = ui.choice(search, {
    label: 'Settings of', name: 'settings-of', value: 0,
    options: [{ value: 0, label: 'A' }, { value: 1, label: 'B' }],
    onChange(value) {
      lane = value;
      SEARCH.forEach(([name], i) => { sliders[i].value = values[lane][name].value; });
      parry.value = values[lane].parry.value;
    },
  });
  who.element.hidden = true;
  ui.toggle(search, {
    label: 'A second character with settings of its own', name: 'second',
    onChange(on) {
      who.element.hidden = !on;
      if (!on) who.value = lane = 0;
      heard.forEach((callback) => callback(on));
    },
  });
  const parry = ui.toggle(search, {
    label: 'Parry what nothing avoids', name: 'parry', value: options.settings.parry.value,
    onChange(on) {
      values[lane].parry = { value: on };
      link.send({ type: 'settings', lane, parry: on });
    },
  });
  const sliders = SEARCH.map((row) => add(search, row));

  function add(parent, [name, label, unit, step]) {
    const { value, low, high } = options.settings[name];
    return ui.slider(parent, {
      label, name, unit, min: low, max: high, step, value,
      onInput(next) {
        const of = SEARCH.some(([each]) => each === name) ? lane : 0;
        values[of][name] = { ...values[of][name], value: next };
        link.send({ type: 'settings', lane: of, [name]: next });
      },
    });
  }

  return { onSecond: (callback) => heard.push(callback) };
}
