"""Building blocks of panels: labelled, usable by keyboard, and shown as what they are told."""

import pytest

from .shows import show_of

BUILD = """() => {
  const { ui } = bench;
  const body = ui.panel(document.getElementById('side'), 'Settings');
  window.heard = [];
  const hear = (name) => (value) => heard.push([name, value]);
  window.made = {
    slider: ui.slider(body, {
      label: 'Ball speed', unit: 'm/s', min: 1, max: 20, step: 0.5, value: 8,
      onInput: hear('input'), onChange: hear('change'),
    }),
    few: ui.choice(body, { label: 'Kind', options: [{ value: 'a', label: 'Ball' },
      { value: 'b', label: 'Bat' }], value: 'a', onChange: hear('few') }),
    many: ui.choice(body, { label: 'Clip', options: [1, 2, 3, 4, 5].map((value) => (
      { value, label: `clip ${value}` })), value: 2, onChange: hear('many') }),
    toggle: ui.toggle(body, { label: 'Ghosts', value: true, onChange: hear('toggle') }),
    sentence: ui.sentence(body),
    bars: ui.bars(body),
    table: ui.table(body),
    list: ui.list(body),
    progress: ui.progress(body),
  };
  ui.button(body, { label: 'Throw ten', onClick: () => heard.push(['button', null]) });
  const onText = (text, name) => heard.push([name, text]);
  ui.fileButton(body, { label: 'Open', accept: '.json', onText });
}"""


@pytest.fixture(scope="module")
def page(shared_bench):
    tab = shared_bench(show_of(), width=1000, height=900)
    tab.evaluate(BUILD)
    return tab


@pytest.fixture(autouse=True)
def nothing_heard(page):
    page.evaluate("heard.length = 0")


def heard(page):
    return page.evaluate("heard")


def test_a_slider_moves_by_key_and_says_its_value(page):
    slider = page.get_by_label("Ball speed")
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert heard(page) == [["input", 8.5], ["change", 8.5]]
    assert slider.get_attribute("data-name") == "ball-speed"
    assert slider.get_attribute("aria-valuetext") == "8.5 m/s"
    page.evaluate("made.slider.value = 3")
    assert slider.input_value() == "3"
    assert page.locator("output.mg-value").inner_text() == "3 m/s"
    assert page.evaluate("mgjax.player.time") == 0


def test_choices(page):
    page.get_by_text("Bat", exact=True).click()
    page.get_by_label("Clip").select_option("clip 4")
    assert heard(page) == [["few", "b"], ["many", 4]]
    page.evaluate("made.few.value = 'a'; made.many.value = 5")
    assert page.evaluate("[made.few.value, made.many.value]") == ["a", 5]


def test_toggle_and_button(page):
    page.get_by_label("Ghosts").press("Space")
    page.get_by_role("button", name="Throw ten").click()
    assert heard(page) == [["toggle", False], ["button", None]]


def test_a_file_is_read_where_the_person_is(page):
    file = {"name": "a.json", "mimeType": "application/json", "buffer": b'{"a": 1}'}
    page.locator('[data-name="open-file"]').set_input_files(file)
    page.wait_for_function("heard.length === 1")
    assert heard(page) == [["a.json", '{"a": 1}']]


def test_words_are_never_markup(page):
    text = "<img src=x onerror=alert(1)> 4 cm"
    page.evaluate("text => made.sentence.set(text, 'good')", text)
    page.evaluate("text => made.table.set([[text, text]])", text)
    assert page.locator(".mg-sentence").inner_text() == text
    assert page.locator("dd").inner_text() == text
    assert page.locator("#side img").count() == 0
    page.evaluate("made.sentence.set('')")
    assert page.locator(".mg-sentence").is_hidden()


def test_bars_are_as_long_as_their_share(page):
    page.evaluate("made.bars.set([{ name: 'distance', value: 1, of: 4 }, { name: 'x', value: 9 }])")
    shares = page.evaluate(
        """() => [...document.querySelectorAll('.mg-bar')].map((bar) => (
          bar.querySelector('i').offsetWidth / bar.querySelector('b').offsetWidth))"""
    )
    assert shares == pytest.approx([0.25, 1], abs=0.02)


def test_a_list_is_picked_from_and_says_when_it_is_empty(page):
    page.evaluate(
        """made.list.set([{ id: 'w', label: 'walk', detail: '4 s' }, { id: 'd', label: 'duck' }],
        (id) => heard.push(['pick', id]))"""
    )
    page.get_by_role("button", name="duck").click()
    assert heard(page) == [["pick", "d"]]
    pressed = page.locator(".mg-entry").evaluate_all("all => all.map((e) => e.ariaPressed)")
    assert pressed == ["false", "true"]
    page.evaluate("made.list.set([], null, 'Nothing here yet.')")
    assert page.locator(".mg-empty").inner_text() == "Nothing here yet."


def test_progress_goes_away_when_done(page):
    page.evaluate("made.progress.set(0.4, 'compiling')")
    assert page.locator(".mg-progress").inner_text() == "compiling"
    page.evaluate("made.progress.set(1)")
    assert page.locator(".mg-progress").is_hidden()


LABELS = """async () => {
  const { drawOverlay } = await import('./overlay.js');
  const { THEMES } = await import('./look.js');
  const boxes = [];
  const paper = new Proxy({}, { get: (_, name) => (name === 'roundRect'
    ? (...box) => boxes.push(box) : name === 'measureText'
      ? (text) => ({ width: 7 * text.length }) : () => {}), set: () => true });
  const labels = [];
  for (let i = 0; i < 12; i += 1) {
    labels.push({ text: `player ${i}`, place: [0.1 * (i % 4), 1.8, 0.1 * i], colour: 'blue' });
  }
  const { camera } = mgjax.stage;
  const taken = [{ left: 0, top: 0, wide: 200, high: 80 }];
  drawOverlay(paper, { camera, theme: THEMES.light, labels, taken: [...taken], handles: null });
  return { boxes, width: camera.width, height: camera.height };
}"""


def test_labels_cover_neither_one_another_nor_what_lies_over_the_picture(page):
    got = page.evaluate(LABELS)
    boxes = [(0, 0, 200, 80), *(tuple(box[:4]) for box in got["boxes"])]
    assert len(boxes) == 13
    for i, (x, y, wide, high) in enumerate(boxes):
        assert x >= 0
        assert y >= 0
        assert x + wide <= got["width"]
        assert y + high <= got["height"]
        for u, v, w, h in boxes[:i]:
            apart = x >= u + w or u >= x + wide or y >= v + h or v >= y + high
            assert apart
