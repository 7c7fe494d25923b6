/** Mouse, pen and touch on the canvas: turned into turning, shifting, zooming, drags and clicks. */

const STILL_PIXELS = 4;

/**
 * Listens to an element until `stop` is called.
 * @param {HTMLElement} element
 * @param {object} does orbit(dx, dy), pan(dx, dy), zoom(factor), hover(x, y), leave(), click(x, y),
 *   grab(x, y) -> {move(x, y), end()} | null for a drag that something else takes, mayZoom() ->
 *   whether the wheel belongs to the picture
 * @returns {() => void} stop
 */
export function listen(element, does) {
  const pointers = new Map();
  let drag = null;
  const stops = [];
  const on = (name, handler, options) => {
    element.addEventListener(name, handler, options);
    stops.push(() => element.removeEventListener(name, handler, options));
  };
  const at = (event) => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  function down(event) {
    if (event.button > 2) return;
    element.dataset.pointed = '';
    element.focus({ preventScroll: true });
    element.setPointerCapture?.(event.pointerId);
    pointers.set(event.pointerId, at(event));
    if (pointers.size === 2) {
      drag?.grabbed?.end();
      drag = { way: 'pinch', moved: true };
      return;
    }
    if (pointers.size > 2) return;
    drag = begin(event, at(event));
  }

  function begin(event, [x, y]) {
    const left = event.button === 0 && !event.shiftKey;
    const grabbed = left ? does.grab(x, y) : null;
    const shift = event.button === 1 || (event.button === 0 && event.shiftKey);
    const way = grabbed ? 'grab' : shift ? 'pan' : 'orbit';
    return { way, grabbed, left, start: [x, y], moved: false };
  }

  function move(event) {
    const [x, y] = at(event);
    const before = pointers.get(event.pointerId);
    if (!before || !drag) {
      if (!pointers.size) does.hover(x, y);
      return;
    }
    if (drag.way === 'pinch') {
      pinch(event.pointerId, [x, y]);
      return;
    }
    pointers.set(event.pointerId, [x, y]);
    if (!drag.moved && Math.hypot(x - drag.start[0], y - drag.start[1]) >= STILL_PIXELS) {
      drag.moved = true;
    }
    if (drag.way === 'grab') {
      const events = event.getCoalescedEvents?.() ?? [];
      for (const each of events.length ? events : [event]) drag.grabbed.move(...at(each));
    } else if (drag.moved) {
      does[drag.way](x - before[0], y - before[1]);
    }
  }

  function pinch(id, here) {
    const other = [...pointers].find(([each]) => each !== id)?.[1];
    const before = pointers.get(id);
    pointers.set(id, here);
    if (!other) return;
    const span = (a) => Math.max(10, Math.hypot(a[0] - other[0], a[1] - other[1]));
    does.zoom(span(before) / span(here));
    does.pan((here[0] - before[0]) / 2, (here[1] - before[1]) / 2);
  }

  function up(event) {
    if (!pointers.delete(event.pointerId) || pointers.size) return;
    const done = drag;
    drag = null;
    done?.grabbed?.end();
    if (done?.left && !done.moved && event.type === 'pointerup') does.click(...at(event));
  }

  on('pointerdown', down);
  on('pointermove', move);
  on('pointerup', up);
  on('pointercancel', up);
  on('pointerleave', () => does.leave());
  on('keydown', () => delete element.dataset.pointed);
  on('contextmenu', (event) => event.preventDefault());
  on('wheel', (event) => {
    if (!does.mayZoom(event)) return;
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    does.zoom(Math.exp(Math.max(-120, Math.min(120, event.deltaY * lines)) * 0.0016));
  }, { passive: false });
  return () => stops.forEach((stop) => stop());
}
