import base64
import gc
import io

import pytest
from imageio_ffmpeg import read_frames
from PIL import Image

from mgjax.core.errors import ConfigError
from mgjax.stage.serve.film import Film


def picture(grey: int, size: tuple[int, int] = (64, 48)) -> str:
    """A JPEG of one grey as a data URL."""
    file = io.BytesIO()
    Image.new("RGB", size, (grey, grey, grey)).save(file, "JPEG")
    return "data:image/jpeg;base64," + base64.b64encode(file.getvalue()).decode()


def frame(number: int, count: int, data: str) -> dict:
    return {"type": "film", "frame": number, "frames": count, "rate": 30, "data": data}


# The reader leaves its pipe to the collector of garbage.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_pictures_become_a_film(tmp_path):
    film = Film()
    made = [film.receive(frame(i, 6, picture(40 * i, (65, 48)))) for i in range(6)]
    assert made[:5] == [None] * 5
    assert made[5] is not None
    assert made[5]["name"] == "film.mp4"
    path = tmp_path / "film.mp4"
    path.write_bytes(bytes(made[5]["data"]))
    reader = read_frames(str(path))
    meta = next(reader)
    assert meta["size"] == (64, 48)
    assert meta["fps"] == 30
    greys = [data[0] for data in reader]
    assert len(greys) == 6
    assert all(abs(grey - 40 * i) < 12 for i, grey in enumerate(greys))
    film.close()
    del reader
    gc.collect()


def test_a_first_frame_begins_anew():
    film = Film()
    film.receive(frame(0, 3, picture(0)))
    film.receive(frame(1, 3, picture(0)))
    assert film.receive(frame(0, 1, picture(0))) is not None


@pytest.mark.parametrize(
    "message",
    [
        frame(1, 3, picture(0)),
        frame(0, 3, "data:image/png;base64,AAAA"),
        frame(0, 3, "data:image/jpeg;base64,!!!!"),
        frame(0, 3, "data:image/jpeg;base64,AAAA"),
        frame(3, 3, picture(0)),
        frame(0, 10**6, picture(0)),
    ],
)
def test_what_is_no_frame(message):
    film = Film()
    with pytest.raises(ConfigError, match="got"):
        film.receive(message)
    film.close()
