"""What the name of a joint hints at: its side, and the part of the body that moves with it.

Makers of capture agree on little: sides stand before, behind or inside a name (``LeftUpLeg``,
``thigh_l``, ``J_Bip_L_UpperLeg``, ``lFemur``), prefixes name a character or a namespace
(``mixamorig:``, ``Bip01 ``), and one word means two joints (``Shoulder``, ``Foot``, ``Leg``). So a
name is a hint with a weight only; :mod:`mgjax.core.body.limbs` weighs it against the tree.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

_WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_SIDES = {
    "left": "left",
    "l": "left",
    "lft": "left",
    "right": "right",
    "r": "right",
    "rgt": "right",
}

SURE, LIKELY, PERHAPS = 6.0, 4.0, 2.0
"""Weights of a hint: the word means this joint, usually does, or means one of two."""

# What occurs in a name without its side, and what it hints at; the first row that fits decides. A
# word with "=" must end the name. See _occurs for the others.
_HINTS: tuple[tuple[str, dict[str, float]], ...] = (
    (
        "end site tip twist roll helper rigmesh share pole effector muscle dummy nub corrective",
        {"helper": SURE},
    ),
    ("thumb index middle mid ring pinky pinkie little finger carpal palm inhand", {"finger": SURE}),
    ("eye jaw brow lip tongue ear cheek nose teeth hair mouth lid face beard", {"face": SURE}),
    ("prop weapon sword gun bag skirt breast bust boob cape", {"prop": SURE}),
    ("tail wing hoof paw hock", {"animal": SURE}),
    ("hipjoint buttock", {"before_hip": SURE}),
    ("toe forefoot ball", {"toe": SURE}),
    ("ankle", {"ankle": SURE}),
    ("foot", {"ankle": LIKELY, "toe": PERHAPS}),
    ("knee shin calf tibia lowerleg lowleg loleg", {"knee": SURE}),
    ("thigh femur upleg upperleg uppleg", {"hip": SURE}),
    ("elbow forearm lowerarm lowarm loarm radius ulna", {"elbow": SURE}),
    ("wrist", {"wrist": SURE}),
    ("hand", {"wrist": LIKELY}),
    ("upperarm uparm humerus shldr", {"shoulder": SURE}),
    ("clavicle collar clav scapula", {"clavicle": SURE}),
    ("shoulder", {"clavicle": PERHAPS, "shoulder": PERHAPS}),
    ("=arm", {"shoulder": SURE}),
    ("=leg", {"knee": LIKELY, "hip": PERHAPS}),
    ("=hip =hips", {"hip": SURE}),
    ("pelvis", {"hips": SURE}),
    ("neck", {"neck": SURE}),
    ("head", {"head": SURE}),
    ("thorax chest ribcage spine abdomen back waist torso stomach", {"spine": SURE}),
)
_ROWS = tuple((tuple(words.split()), hint) for words, hint in _HINTS)


@dataclass(frozen=True, kw_only=True)
class NameHint:
    """What a name says.

    Attributes:
        side: ``"left"``, ``"right"`` or ``""``.
        words: lower case words without the side: equal for the two sides of a pair.
        weights: part of the body → weight.
    """

    side: str
    words: tuple[str, ...]
    weights: dict[str, float]

    def weight(self, part: str) -> float:
        return self.weights.get(part, 0.0)

    def has(self, *parts: str) -> bool:
        return any(part in self.weights for part in parts)


def bare(name: str) -> str:
    """The name without a namespace such as ``mixamorig7:`` or ``Group|Rig|``."""
    return re.split(r"[:|]", name)[-1] or name


@lru_cache(maxsize=4096)
def read_name(name: str) -> NameHint:
    """The hint of one name, taken alone."""
    words = [w.lower() for w in _WORDS.findall(bare(name))]
    side = ""
    for at, word in enumerate(words):
        rest = words[:at] + words[at + 1 :]
        if word in _SIDES and any(not w.isdigit() for w in rest):  # "L5" is a vertebra
            side, words = _SIDES[word], rest
            break
    else:
        side, words = _glued_side(words)
    weights = _weigh(words)
    if weights == {"hip": SURE} and not side:
        weights = {"hips": SURE}
    return NameHint(side=side, words=tuple(words), weights=weights)


def _glued_side(words: list[str]) -> tuple[str, list[str]]:
    """Side of ``lfemur``, ``rightfoot``: a letter or word before a known word."""
    for at, word in enumerate(words):
        for prefix in ("left", "right", "l", "r"):
            rest = word.removeprefix(prefix)
            if rest != word and rest in _KNOWN:
                return _SIDES[prefix], [*words[:at], rest, *words[at + 1 :]]
    return "", words


def _weigh(words: list[str]) -> dict[str, float]:
    letters = [w for w in words if not w.isdigit()]
    text = "".join(letters)
    for options, hint in _ROWS:
        if any(_occurs(option, letters, text) for option in options):
            return dict(hint)
    return {}


def _occurs(option: str, words: list[str], text: str) -> bool:
    """Long words may stand anywhere; short ones (``ear`` is in ``forearm``) begin or end a word."""
    if option[0] == "=":
        return text.endswith(option[1:])
    if len(option) > 4:
        return option in text
    begins = any(word.startswith(option) for word in words)
    return begins or (len(option) == 4 and text.endswith(option))


_KNOWN = frozenset(
    form
    for words, _ in _HINTS
    for word in words.replace("=", "").split()
    for form in (word, f"{word}s", f"{word}base")
)
