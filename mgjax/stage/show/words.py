"""What came of an attack, in words and bars; the same from objects and from files."""

from __future__ import annotations

from collections.abc import Mapping

from mgjax.stage.show.types import Bar, Colour

DROPPED = {
    "culled": "dropped: culled by slices",
    "not_adjustable": "dropped: no edge may change its speed",
    "time_scale": "dropped: time scale out of range",
    "hit": "dropped: touched by the attack",
    "overflow": "dropped: not judged",
}
"""Why candidates are dropped, by the field that counts them."""
_NEAR_M = 2.0
"""Farther away nobody cares how far."""


def avoided_words(
    status: str, kind: str | None, clearance_m: float | None, limb: str | None = None
) -> str:
    """One sentence.

    Args:
        status: ``avoided``, ``hit``, ``no_candidate`` or ``parried``.
        kind: of the avoidance, such as ``duck``; None without one.
        clearance_m: from the attack to the body, negative where it is hit.
        limb: that parries, such as ``left_forearm``.
    """
    if status == "parried" and limb is not None:
        return f"parried with the {limb.replace('_', ' ')}: nothing avoids it"
    if status == "no_candidate" or kind is None or clearance_m is None:
        return "no candidate: no avoidance part comes at the right time"
    if status == "hit":
        return f"hit, {length_words(-clearance_m)} deep, in spite of {kind}"
    return f"avoided by {kind}, {length_words(clearance_m)} clear"


def status_colour(status: str) -> Colour:
    """Green what is avoided, orange what is parried, red the rest."""
    known: dict[str, Colour] = {"avoided": "green", "parried": "orange"}
    return known.get(status, "red")


def length_words(metres: float) -> str:
    """A distance of surfaces: in millimetres below one centimetre."""
    if metres > _NEAR_M:
        return f"more than {_NEAR_M:g} m"
    if metres < 0.0095:
        return f"{1000 * metres:.0f} mm"
    return f"{100 * metres:.0f} cm"


def energy_bars(energies: Mapping[str, float]) -> list[Bar]:
    """The energies of a choice by their names, those of them that are there; 1 fills a bar."""
    shown: tuple[tuple[str, str, Colour], ...] = (
        ("avoidance", "avoidance", "blue"),
        ("body", "body", "orange"),
        ("movement", "movement", "purple"),
        ("timescale", "time scale", "green"),
    )
    return [
        Bar(name=words, value=energies[name], of=max(energies[name], 1.0), colour=colour)
        for name, words, colour in shown
        if name in energies
    ]
