"""What came of a throw, in words and figures."""

from __future__ import annotations

from typing import Any

from mgjax.avoidance.choice.results import Choice
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.energy.score import Energy
from mgjax.avoidance.play.answers import Answer, Found
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.throw.contact import Contact
from mgjax.stage.show.words import DROPPED, length_words


def kind_of(graph: MotionGraph, part: int) -> str:
    """What an avoidance part does, such as ``duck`` or ``sway left``."""
    return f"{graph.label_kind[part]} {graph.label_direction[part]}".strip().replace("_", " ")


def expected(graph: MotionGraph, found: Found) -> str:
    """What a search found, before the ball is there."""
    choice, path = found.path.choice, found.path
    took = f"{1000 * path.seconds:.1f} ms"
    if path.parry is not None:
        return (
            f"will parry with the {path.parry.limb.replace('_', ' ')}: nothing avoids it ({took})"
        )
    if choice is None or choice.part is None:
        return f"no candidate: no avoidance part comes at the right time ({took})"
    kind = kind_of(graph, choice.part)
    if path.status == "hit":
        return f"will be hit: of {choice.candidates} candidates none stays clear ({took})"
    gap = length_words(choice.clearance_m or 0.0)
    return f"will {kind}, {gap} clear: best of {choice.candidates} ({took})"


def outcome(
    graph: MotionGraph, answer: Answer, found: Found | None, contact: Contact | None
) -> tuple[str, str]:
    """The sentence on what was played, and its tone."""
    took = "" if found is None else f", {1000 * found.path.seconds:.1f} ms"
    gap = answer.clearance_m
    choice = None if found is None else found.path.choice
    kind = "" if choice is None or choice.part is None else kind_of(graph, choice.part)
    if answer.hit:
        where = "" if contact is None else f" on the {contact.part}"
        return f"hit{where}, {length_words(-gap)} deep: {_why_hit(answer, kind)}{took}", "bad"
    if answer.limb is not None:
        return f"parried with the {answer.limb.replace('_', ' ')}{took}", "good"
    if answer.status == "superseded":
        return f"the next ball came first; this one passed {length_words(gap)}", "plain"
    if answer.search == "avoided":
        return f"avoided by {kind}, {length_words(gap)} clear{took}", "good"
    return (
        f"passed {length_words(gap)} off without an avoidance: {_why_hit(answer, kind)}{took}",
        "plain",
    )


def _why_hit(answer: Answer, kind: str) -> str:
    if answer.search == "committed":
        return "what was being played could not be left in time"
    if answer.search == "late":
        return "the search ended too late"
    if answer.search == "no_candidate":
        return "no avoidance part comes at the right time"
    if answer.search == "hit":
        return f"no candidate stays clear, {kind} comes nearest" if kind else "no way out"
    return f"{kind} was planned for one ball, another came"


def figures(config: AvoidanceConfig, found: Found | None) -> dict[str, Any]:
    """Rows and bars for the panel: candidates, why they were dropped, energies, times."""
    if found is None:
        return {"rows": [["search", "none had ended when the ball came"]], "bars": []}
    choice = found.path.choice
    rows: list[list[str]] = [["search", f"{1000 * found.path.seconds:.1f} ms"]]
    if choice is None:
        return {"rows": rows, "bars": []}
    rows.append(["candidates", str(choice.candidates)])
    for name, words in DROPPED.items():
        count = getattr(choice.dropped, name)
        if count:
            rows.append([words, str(count)])
    if choice.time_scale is not None:
        rows.append(["time scale", f"{choice.time_scale:.2f}"])
    if choice.clearance_m is not None:
        rows.append(["clearance expected", length_words(choice.clearance_m)])
    rows.append(["path", f"{choice.path_length} edges"])
    return {"rows": rows, "bars": energy_bars(config, choice)}


def energy_bars(config: AvoidanceConfig, choice: Choice) -> list[dict[str, Any]]:
    """The weighted energies of a choice; the sum is what is minimised (eq. 10)."""
    energy, weights = choice.energy, config.energy
    if energy is None:
        return []
    terms = [
        ("avoidance", energy.avoidance, float(weights.w_a), "blue"),
        ("body", energy.body, float(weights.w_b), "orange"),
        ("movement", energy.movement, float(weights.w_m), "purple"),
        ("time scale", energy.timescale, float(weights.w_t), "green"),
    ]
    bars = [
        {
            "name": name,
            "value": weight * value,
            "of": max(weight * max(value, 1.0), 1e-6),
            "colour": colour,
        }
        for name, value, weight, colour in terms
    ]
    whole = sum(bar["of"] for bar in bars)
    return [*bars, {"name": "total", "value": energy.total, "of": whole, "colour": "grey"}]


def energy_of_words(energy: Energy | None) -> str:
    """The total energy of a candidate."""
    return "not timed" if energy is None else f"energy {energy.total:.2f}"
