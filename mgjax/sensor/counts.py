"""What became of all that was received, and why nothing came of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(kw_only=True)
class Counts:
    """What became of all that was received.

    Attributes:
        datagrams: received.
        malformed: broken datagrams, and broken messages in others; dropped.
        unknown: messages with an address, or bones with a name, that is not used; ignored.
        foreign: datagrams of a second sender while the first still sends; dropped unread.
        stale: datagrams of a frame that is over, or of an earlier one; dropped.
        frames: given out.
        overrun: frames dropped, the oldest first, because nobody took them.
        streams: times that a sender started anew.
        bones: messages with a bone that is used.
        strange_bone: the first bone's name that is none of the humanoid; "" while there is none.
        missing_bones: names of bones that a body needs and that have not come from the sender.
        no_body: frames during which the sender said that it has no body.
        sender: who is listened to, in words; "" before anybody.
        clock_fault: what is wrong with the sender's clock, so that the times of arrival are used;
            "" while nothing is.
    """

    datagrams: int = 0
    malformed: int = 0
    unknown: int = 0
    foreign: int = 0
    stale: int = 0
    frames: int = 0
    overrun: int = 0
    streams: int = 0
    bones: int = 0
    strange_bone: str = ""
    missing_bones: tuple[str, ...] = ()
    no_body: int = 0
    sender: str = ""
    clock_fault: str = ""


def why_nothing(counts: Counts, place: str) -> str:
    """One sentence that says why no frame has come; "" where one has.

    Args:
        counts: so far.
        place: address and port that are listened on, such as ``127.0.0.1:39539``.
    """
    came = f"{counts.datagrams} packets came on {place}"
    if counts.frames:
        return ""
    if counts.datagrams == 0:
        return (
            f"no packet came on {place}: expected a sender that sends there (only from this"
            " machine, unless --host is an address that others reach)"
        )
    if counts.foreign > counts.datagrams // 2:
        return (
            f"{came}, {counts.foreign} of them from another address than {counts.sender}, which"
            " was first and still sends: expected one sender"
        )
    if counts.bones == 0:
        return f"{came}, {_without_bones(counts)}"
    if counts.missing_bones:
        names = ", ".join(counts.missing_bones)
        return f"{came} with {counts.bones} bones, but without {names}: a body has hips and legs"
    if counts.no_body:
        return f"{came}, but in {counts.no_body} frames the sender says that it has no body loaded"
    return f"{came} with {counts.bones} bones: too few frames yet to know the body by"


def _without_bones(counts: Counts) -> str:
    if counts.strange_bone:
        return (
            f"but the bones have names such as {counts.strange_bone!r}, expected those of Unity's"
            " humanoid, such as Hips and LeftFoot"
        )
    if counts.malformed and not counts.unknown:
        return (
            f"{counts.malformed} of them broken: expected OSC messages or bundles with"
            " /VMC/Ext/Bone/Pos (a name and seven numbers)"
        )
    return (
        f"but none had a bone that is used ({counts.unknown} messages with other addresses or"
        f" bones, {counts.malformed} broken): expected /VMC/Ext/Bone/Pos"
    )
