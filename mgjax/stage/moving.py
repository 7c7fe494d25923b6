"""A show as one small picture that moves wherever pictures are shown, also where no script runs."""

from __future__ import annotations

import io
import math

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from mgjax.core import quaternion
from mgjax.stage.show.types import Actor, Ball, Body, Show
from mgjax.stage.still import LIGHT, PALETTE, placed_surface, seen_from_the_side, still_png

RATE = 8.0
"""Pictures a second, as played."""
MOST = 24
"""Pictures at most; a longer show is played faster, which its words say."""
SIZE = (416, 234)
_FINE = 2
"""Pictures are drawn larger by this factor, and made smaller, for smooth edges."""
_COLOURS = 32
_TOP_PX = 22
_WHITE = np.array([255.0, 255.0, 255.0])


def moving_png(show: Show) -> bytes:
    """An animated PNG of a show; what cannot play one shows :func:`still_png`, its default image.

    The eye stands still, far away, a little above. A show of one moment is its still picture.
    """
    still = still_png(show)
    if show.seconds < 2 / RATE or not (show.actors or show.balls):
        return still
    count = min(MOST, math.ceil(show.seconds * RATE))
    times = np.arange(count) * (show.seconds / count)
    actors = [_Posed(show.bodies[actor.body], actor, times) for actor in show.actors]
    camera = _Camera(show, actors)
    faster = show.seconds * RATE / count
    words = f"{show.title}: {show.words}" if show.words else show.title
    speed = f", {faster:.1f} times as fast" if faster > 1.05 else ""
    pictures = [
        _picture(show, actors, camera, number, float(time), f"{time:.1f} s{speed}", words)
        for number, time in enumerate(times)
    ]
    with Image.open(io.BytesIO(still)) as first:
        return _animated([first.convert("RGB").resize(SIZE), *pictures])


class _Posed:
    """The surface of an actor at each time, as the picture sees it, with its colours."""

    def __init__(self, body: Body, actor: Actor, times: np.ndarray) -> None:
        frames = actor.frames
        turns = frames.rotations.astype(np.int16)
        if frames.delta:
            turns = np.cumsum(turns, axis=0, dtype=np.int16)
        last = len(frames.root) - 1
        moments = np.clip(np.rint((times - frames.start) * frames.rate), 0, last).astype(int)
        self.there = np.ones(len(times), bool)
        if actor.look == "ghost":
            end = frames.start + last / frames.rate
            self.there = (times >= frames.start) & (times <= end)
        hue = np.array([int(PALETTE[actor.colour][i : i + 2], 16) for i in (1, 3, 5)])
        self.hue = _WHITE + (0.35 if actor.look == "ghost" else 1.0) * (hue - _WHITE)
        self.triangles = body.mesh.triangles.astype(int)
        self.flat = []
        for moment in moments:
            local = np.asarray(quaternion.normalise(turns[moment].astype(np.float64) / 32767))
            root = np.asarray(frames.root[moment], np.float64)
            self.flat.append(seen_from_the_side(placed_surface(body, root, local)))

    def draw(self, draw: ImageDraw.ImageDraw, camera: _Camera, number: int) -> None:
        flat = self.flat[number]
        corners = flat[self.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-12
        front = np.flatnonzero(normals[:, 2] > 0)
        front = front[np.argsort(corners[front, :, 2].mean(axis=1))]
        shade = 0.45 + 0.55 * np.clip(normals[front] @ LIGHT, 0, 1)
        colours = (shade[:, None] * self.hue).astype(int).tolist()
        places = camera.pixels(flat)[self.triangles[front]].reshape(-1, 6).tolist()
        for place, colour in zip(places, colours, strict=True):
            draw.polygon(place, fill=tuple(colour))


class _Camera:
    """From metres as they are seen to pixels, so that all of the show is in the picture."""

    def __init__(self, show: Show, actors: list[_Posed]) -> None:
        seen = [np.zeros((1, 2))]
        seen += [flat[:, :2] for actor in actors for flat in actor.flat]
        seen += [seen_from_the_side(line.points)[:, :2] for line in show.lines]
        for thing in show.things:
            ends = [thing.place] if thing.end is None else [thing.place, thing.end]
            seen.append(seen_from_the_side(np.array(ends, float))[:, :2])
        places = np.concatenate(seen)
        low, high = places.min(axis=0) - 0.12, places.max(axis=0) + 0.12
        room = np.array([SIZE[0], SIZE[1] - _TOP_PX])
        self.scale = _FINE * float((room / (high - low)).min())
        self.middle = (low + high) / 2
        self.centre = _FINE * np.array([SIZE[0] / 2, _TOP_PX + room[1] / 2])

    def pixels(self, flat: np.ndarray) -> np.ndarray:
        """Places as seen, m, as pixels of the fine picture. [N,2]"""
        return self.centre + self.scale * (flat[:, :2] - self.middle) * (1, -1)


def _picture(
    show: Show,
    actors: list[_Posed],
    camera: _Camera,
    number: int,
    time: float,
    clock: str,
    words: str,
) -> Image.Image:
    image = Image.new("RGB", (_FINE * SIZE[0], _FINE * SIZE[1]), "white")
    draw = ImageDraw.Draw(image)
    for line in show.lines:
        flat = camera.pixels(seen_from_the_side(line.points))
        colour = PALETTE[line.colour]
        draw.line(flat.ravel().tolist(), fill=colour, width=round(line.width * _FINE / 2))
    for thing in show.things:
        ends = [thing.place] if thing.end is None else [thing.place, thing.end]
        flat = camera.pixels(seen_from_the_side(np.array(ends, float)))
        thick = max(round(2 * thing.radius * camera.scale), _FINE)
        if len(flat) > 1:
            draw.line(flat.ravel().tolist(), fill=PALETTE[thing.colour], width=thick)
        else:
            _disc(draw, flat[0], thick / 2, PALETTE[thing.colour])
    for ball in show.balls:
        if ball.trail:
            flat = camera.pixels(seen_from_the_side(ball.places))
            draw.line(flat.ravel().tolist(), fill="#e8d6b8", width=_FINE)
    things = [(actor.flat[number][:, 2].mean(), actor) for actor in actors if actor.there[number]]
    things += [
        (float(seen_from_the_side(_place(ball, time))[0, 2]), ball)
        for ball in show.balls
        if ball.times[0] <= time <= ball.times[-1]
    ]
    for _, thing in sorted(things, key=lambda pair: pair[0]):
        if isinstance(thing, _Posed):
            thing.draw(draw, camera, number)
        else:
            (middle,) = camera.pixels(seen_from_the_side(_place(thing, time)))
            _disc(draw, middle, thing.radius * camera.scale, PALETTE[thing.colour])
    font = ImageFont.load_default(11 * _FINE)
    draw.text((8 * _FINE, 5 * _FINE), words[:66], fill="#1d2329", font=font)
    wide = draw.textlength(clock, font=font)
    draw.text(
        (_FINE * (SIZE[0] - 8) - wide, _FINE * (SIZE[1] - 18)), clock, fill="#6b7280", font=font
    )
    return image.reduce(_FINE)


def _place(ball: Ball, time: float) -> np.ndarray:
    """Where a ball is, m. [1,3]"""
    return np.array([[np.interp(time, ball.times, ball.places[:, i]) for i in range(3)]])


def _disc(draw: ImageDraw.ImageDraw, middle: np.ndarray, radius: float, colour: str) -> None:
    x, y = middle.tolist()
    radius = max(radius, 2.0 * _FINE)
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=colour)


def _animated(images: list[Image.Image]) -> bytes:
    """The first image, and an animation of the others; all with the colours of one small table."""
    sheet = Image.new("RGB", (SIZE[0], SIZE[1] * len(images)))
    for number, image in enumerate(images):
        sheet.paste(image, (0, SIZE[1] * number))
    table = sheet.quantize(_COLOURS)
    first, *rest = [image.quantize(palette=table, dither=Image.Dither.NONE) for image in images]
    data = io.BytesIO()
    first.save(
        data, format="png", save_all=True, append_images=rest, default_image=True,
        duration=round(1000 / RATE), loop=0,
    )  # fmt: skip
    return data.getvalue()
