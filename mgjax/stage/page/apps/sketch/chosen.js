/** The things that stand there as a list, and what can be set of the one that is chosen. */

const WHEN = [
  { value: 'start', label: 'Before' }, { value: 'passing', label: 'Passing' },
  { value: 'end', label: 'After' }, { value: 'at', label: 'At' },
];

/** @returns {{id: string | null, set(items), pick(id)}} */
export function createChosen({ ui, side, link }) {
  const body = ui.panel(side, 'Things');
  const list = ui.list(body, 'things');
  const when = ui.choice(body, {
    label: 'When', name: 'when', value: 'passing', options: WHEN, onChange: (value) => sendWhen(value, true),
  });
  const at = ui.slider(body, {
    label: 'Seconds of the walk', name: 'at-seconds', unit: 's', min: 0, max: 20, step: 0.1, value: 2,
    onInput: () => sendWhen('at', false), onChange: () => sendWhen('at', true),
  });
  const hold = slider('Held for', 'hold', 's', 0, 3, 0.1);
  const radius = slider('Radius', 'radius', 'm', 0.05, 1, 0.05);
  const remove = ui.button(body, {
    label: 'Remove', name: 'remove', title: 'Delete', onClick: () => link.send({ type: 'remove', id: state.id }),
  });
  const state = { id: null, items: [], last: null };

  function slider(label, name, unit, min, max, step) {
    const send = (value, done) => set({ [name]: value }, done);
    return ui.slider(body, {
      label, name, unit, min, max, step, value: min,
      onInput: (value) => send(value, false), onChange: (value) => send(value, true),
    });
  }

  function set(fields, done) {
    link.send({ type: 'set', id: state.id, ...fields, done, ...(done ? {} : { latest: true }) });
  }

  function sendWhen(value, done) {
    at.element.hidden = value !== 'at';
    set(value === 'at' ? { when: 'at', seconds: at.value } : { when: value }, done);
  }

  function show() {
    const item = state.items.find(({ id }) => id === state.id) ?? null;
    const timed = item !== null && item.when !== null && item.when !== undefined;
    const number = timed && typeof item.when === 'number';
    when.element.hidden = hold.element.hidden = !timed;
    at.element.hidden = !number;
    radius.element.hidden = item?.radius === undefined;
    remove.hidden = item === null;
    list.picked = state.id;
    if (timed) {
      when.value = number ? 'at' : item.when;
      hold.value = item.hold;
      if (number) at.value = item.when;
    }
    if (item?.radius !== undefined) radius.value = item.radius;
  }

  const chosen = {
    get id() { return state.id; },
    /** The things that there are; one that was just placed is chosen. */
    set(items) {
      const known = new Set(state.items.map(({ id }) => id));
      const added = items.filter(({ id }) => !known.has(id));
      state.items = items;
      if (added.length === 1) state.id = added[0].id;
      if (!items.some(({ id }) => id === state.id)) state.id = null;
      list.set(
        items.map(({ id, name, words }) => ({ id, label: name, detail: words ?? 'walked around' })),
        chosen.pick,
        'Nothing stands there yet: take a tool and click on the floor.',
      );
      show();
    },
    pick(id) {
      state.id = state.items.some((item) => item.id === id) ? id : null;
      show();
    },
  };
  chosen.set([]);
  return chosen;
}
