/** Elements of the page, made without markup so that no text is ever read as such. */

/**
 * An element with properties, attributes (`data-…`, `aria-…`, `role`, `for`) and children.
 * @param {string} tag
 * @param {object} settings `class`, `text`, `on: {event: handler}`, other names as they are
 * @param {...(Node | string)} children
 */
export function element(tag, settings = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(settings)) {
    if (value === undefined || value === null) continue;
    if (name === 'class') made.className = value;
    else if (name === 'text') made.textContent = value;
    else if (name === 'on') {
      for (const [event, handler] of Object.entries(value)) made.addEventListener(event, handler);
    } else if (/^(data-|aria-|role$|for$|list$)/.test(name)) made.setAttribute(name, value);
    else made[name] = value;
  }
  made.append(...children);
  return made;
}

let made = 0;

/** A name that no other element of the page has. */
export function freshId() {
  made += 1;
  return `mg-${made}`;
}

/** A stable `data-name` from what a control is called: lower case, hyphens. */
export function nameOf(label) {
  return label.toLowerCase().replace(/[^a-z0-9]+/g, '-').replace(/^-|-$/g, '');
}

/** A number as it is read: up to three figures after the point, none of them idle. */
export function readable(value) {
  const places = Math.abs(value) >= 100 ? 0 : Math.abs(value) >= 10 ? 1 : 2;
  return String(Number(value.toFixed(Math.abs(value) < 0.1 && value !== 0 ? 3 : places)));
}

/** Seconds as 0:07.3. */
export function clock(seconds) {
  const tenths = Math.round(Math.max(0, seconds) * 10);
  const minutes = Math.floor(tenths / 600);
  const rest = (tenths - minutes * 600) / 10;
  return `${minutes}:${rest < 10 ? '0' : ''}${rest.toFixed(1)}`;
}
