"""Slices in plain float64, one pixel, layer and sphere at a time, written from the definitions."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from tests.reference.avoidance import compose, inverse
from tests.reference.kinematics import planar_apply

LAYERS, LAYER, PIXEL = 9, 0.25, 0.04
BODY_BIN, BODY_MOMENTS = 0.1, 7
ATTACK_BIN = 0.05
TIE = 1e-4
"""Middles this near to the border of a pixel may be read on either side, m."""

Pixel = tuple[int, int, int]


def pixels_of(centre, radius) -> set[Pixel]:
    """(layer, column, row) whose middle is within the sphere's widest section in the layer."""
    found = set()
    x, y, z = (float(c) for c in centre)
    spans = [
        range(math.floor((c - radius) / PIXEL) - 1, math.floor((c + radius) / PIXEL) + 2)
        for c in (x, z)
    ]
    for layer in range(LAYERS):
        nearest = min(max(y, layer * LAYER), (layer + 1) * LAYER)
        square = radius**2 - (nearest - y) ** 2
        for column, row in product(*spans):
            across = ((column + 0.5) * PIXEL - x) ** 2 + ((row + 0.5) * PIXEL - z) ** 2
            if across <= square:
                found.add((layer, column, row))
    return found


def body_at(tables, edge, time) -> np.ndarray:
    """[S, 3] in the edge's frame, linear between the samples of the tables."""
    steps = int(tables.pool_steps[edge])
    where = min(max(time / float(tables.seconds[edge]) * steps, 0.0), float(steps))
    low = min(int(where + 1e-9), steps - 1)
    rows = tables.pool[int(tables.pool_first[edge]) + low :][:2].astype(np.float64)
    return ((1 - where + low) * rows[0] + (where - low) * rows[1]).reshape(3, -1).T


def bins_of(tables, edge) -> int:
    return max(math.ceil(float(tables.seconds[edge]) / BODY_BIN - 1e-6), 1)


def bin_pixels(tables, edge, number) -> set[Pixel]:
    """Where the body is at the moments of one bin."""
    begin = number * BODY_BIN
    end = min(begin + BODY_BIN, float(tables.seconds[edge]))
    found = set()
    for moment in range(BODY_MOMENTS):
        time = begin + (end - begin) * moment / (BODY_MOMENTS - 1)
        for centre, radius in zip(body_at(tables, edge, time), tables.spheres.radii, strict=True):
            found |= pixels_of(centre, float(radius))
    return found


def edge_pixels(tables, edge) -> set[Pixel]:
    return set().union(*(bin_pixels(tables, edge, b) for b in range(bins_of(tables, edge))))


def attack_pixels(attack, crop) -> list[tuple[float, set[Pixel]]]:
    """Middle of each bin of the crop, and the pixels drawn in it."""
    seconds = crop.end - crop.start
    bins = max(math.ceil(seconds / ATTACK_BIN - 1e-6), 1)
    way = attack.largest_speed * seconds / bins
    pieces = max(math.ceil(way / float(min(attack.radii))), 1)
    found = []
    for number in range(bins):
        pixels = set()
        for piece in range(pieces + 1):
            time = crop.start + seconds * (number + piece / pieces) / bins
            time = min(max(time, crop.start), crop.end)
            there = attack.active(np.array([time]))[0]
            for i, centre in enumerate(attack.at(np.array([time]))[0]):
                if there[i]:
                    pixels |= pixels_of(centre, float(attack.radii[i]))
        found.append((crop.start + seconds * (number + 0.5) / bins, pixels))
    return found


def reads(pixel: Pixel, place) -> set[Pixel]:
    """The body's pixels in which the middle of an attack's pixel may fall: one, at a border two."""
    layer, column, row = pixel
    point = ((column + 0.5) * PIXEL, 0.0, (row + 0.5) * PIXEL)
    x, _, z = planar_apply(inverse(place), point)
    return {
        (layer, math.floor((x + dx) / PIXEL), math.floor((z + dz) / PIXEL))
        for dx, dz in product((-TIE, TIE), repeat=2)
    }


class Overlap:
    """Counts of common pixels; where a middle falls on a border, the least and the most."""

    def __init__(self, tables) -> None:
        self.tables = tables
        self.bins: dict[tuple[int, int], set[Pixel]] = {}
        self.edges: dict[int, set[Pixel]] = {}

    def _bin(self, edge, number) -> set[Pixel]:
        if (edge, number) not in self.bins:
            self.bins[edge, number] = bin_pixels(self.tables, edge, number)
        return self.bins[edge, number]

    def _edge(self, edge) -> set[Pixel]:
        if edge not in self.edges:
            self.edges[edge] = edge_pixels(self.tables, edge)
        return self.edges[edge]

    def _walk(self, edges, scales):
        """Edge, begin, end, scale and place of each edge."""
        begin, place = 0.0, np.zeros(3)
        for edge, scale in zip(edges, scales, strict=True):
            end = begin + float(self.tables.seconds[edge]) * float(scale)
            yield int(edge), begin, end, float(scale), place
            begin, place = end, compose(place, self.tables.step[edge])

    def binned(self, edges, scales, drawn) -> tuple[int, int]:
        least = most = 0
        for time, pixels in drawn:
            for edge, begin, end, scale, place in self._walk(edges, scales):
                if not begin <= time < end:
                    continue
                number = int((time - begin) / scale / BODY_BIN)
                body = self._bin(edge, min(number, bins_of(self.tables, edge) - 1))
                for pixel in pixels:
                    found = reads(pixel, place)
                    least += found <= body
                    most += bool(found & body)
        return least, most

    def paper(self, edges, scales, drawn, crop) -> tuple[int, int]:
        sure, perhaps = set(), set()
        attack = set().union(*(pixels for _, pixels in drawn))
        for edge, begin, end, _, place in self._walk(edges, scales):
            if end <= crop.start or begin > crop.end:
                continue
            body = self._edge(edge)
            for pixel in attack:
                found = reads(pixel, place)
                if found <= body:
                    sure.add(pixel)
                if found & body:
                    perhaps.add(pixel)
        return len(sure), len(perhaps)
