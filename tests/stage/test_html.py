import base64
import json
import re
import struct
import zlib

import numpy as np
import pytest

import mgjax
from mgjax.clips.synthetic import synthetic_clips
from mgjax.core.errors import MgjaxError, OutputError
from mgjax.core.motion import cut
from mgjax.stage.bundle import bundle, page_text
from mgjax.stage.html import page_html
from mgjax.stage.packet import unpack
from mgjax.stage.show.motion import motion_show


@pytest.fixture(scope="module")
def walking():
    clip = next(clip for clip in synthetic_clips()[0] if clip.name == "walk")
    return clip.skeleton, cut(clip.motion, 0, min(301, clip.motion.num_frames))


def test_every_import_of_the_bundle_is_in_it():
    modules = bundle("offline.js")
    assert "stage/offline.js" in modules
    for name, source in modules.items():
        lines = re.findall(r"^(?:import|export \{)[^;]*;", source, re.MULTILINE)
        imports = {text for line in lines for text in re.findall(r"'([^']+)'", line)}
        assert imports <= set(modules), name
        assert not re.search(r"(?:from|import) '\.", source), name
        assert len(source) > 100
        assert "import(" not in source


def test_only_what_is_needed_is_in_it():
    assert not any("live" in name or "apps" in name for name in bundle("offline.js"))
    assert bundle("packet.js").keys() == {"stage/packet.js"}


def test_the_page_holds_modules_and_show(tmp_path, walking):
    path = tmp_path / "page.html"
    mgjax.save_html(path, walking, title="A & <walk>")
    text = path.read_text()
    assert "<title>A &amp; &lt;walk&gt;</title>" in text
    (packed,) = re.findall(r'id="mgjax-payload"[^>]*>([^<]+)<', text)
    data = zlib.decompress(base64.b64decode(packed))
    (size,) = struct.unpack("<I", data[:4])
    assert json.loads(data[4 : 4 + size]) == bundle("offline.js")
    show = unpack(data[4 + size :])
    assert show["title"] == "A & <walk>"
    wanted = motion_show(*walking).actors[0].frames.rotations
    np.testing.assert_array_equal(show["actors"][0]["frames"]["rotations"], wanted)


def test_the_page_names_nothing_elsewhere(walking):
    text = page_html(motion_show(*walking))
    assert not re.search(r"https?:", text)
    assert text.count("<script") == text.count("</script>") == 2
    assert "default-src 'none'" in text


def test_ten_seconds_take_a_quarter_of_a_megabyte(walking):
    assert walking[1].seconds > 9
    assert len(page_html(motion_show(*walking)).encode()) < 250_000


def test_the_boot_script_is_what_the_page_ships():
    assert "mgjax-payload" in page_text("boot.js")


def test_what_cannot_be_shown_says_so(tmp_path):
    with pytest.raises(MgjaxError, match="got 'int', expected a motion"):
        mgjax.save_html(tmp_path / "page.html", 3)
    assert not list(tmp_path.iterdir())


def test_nothing_is_left_where_nothing_can_be_written(tmp_path, walking):
    with pytest.raises(OutputError, match="cannot be written"):
        mgjax.save_html(tmp_path / "missing" / "page.html", walking)
