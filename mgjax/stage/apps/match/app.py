"""The application ``match`` of the page."""

from __future__ import annotations

from mgjax.ballsport.clipset.repertoire import Repertoire
from mgjax.ballsport.live.recogniser import LiveDriver
from mgjax.ballsport.scene.build import prepare_scene
from mgjax.clips.folder import load_clips
from mgjax.clips.synthetic_kicks import synthetic_kicks
from mgjax.clips.types import Clip
from mgjax.stage.apps.match.pitch import COUNTS, pitch
from mgjax.stage.apps.match.rehearsal import Rehearsal
from mgjax.stage.apps.match.session import MatchSession
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.session import Progress, Send
from mgjax.stage.show.body import body_of

_MOST_CLIPS = 60
_OTHER_SEED = 5
"""Clips that are played as the user are others than the stored ones."""


class MatchApp:
    """See :class:`mgjax.stage.serve.session.App`."""

    def __init__(self, folder: str) -> None:
        self._folder = folder
        self._moves: Repertoire | None = None
        self._clips: dict[str, Clip] = {}
        self._rehearsal: Rehearsal | None = None
        self._opened = 0

    def prepare(self, progress: Progress) -> None:
        """Loads the kicks, and rehearses the first pitch."""
        progress(0.02, "reading the kicks")
        config = pitch(COUNTS[0], net=True, clips=self._folder)
        moves = prepare_scene(config)
        self._clips = clips_of_user(self._folder)
        progress(0.25, "making the body")
        body_of(moves.clips.skeleton)
        progress(0.3, "learning to recognise kicks")
        LiveDriver(moves.clips, bones=tuple(dict.fromkeys(moves.clips.hit_bone)))
        progress(0.4, "the players warm up")
        self._moves, self._rehearsal = moves, Rehearsal(moves)
        self._rehearsal.begin(config)

    def open(self, send: Send) -> MatchSession:
        """A new tab."""
        assert self._moves is not None
        assert self._rehearsal is not None
        self._opened += 1
        return MatchSession(
            send,
            self._moves,
            self._clips,
            folder=self._folder,
            seed=self._opened,
            rehearsal=self._rehearsal,
        )

    def close(self) -> None:
        """Ends what still goes on in the background."""
        if self._rehearsal is not None:
            self._rehearsal.close()


def make_app(options: Options) -> MatchApp:
    """The application, on the embedded kicks and those of a folder, if there is one."""
    return MatchApp("" if options.clips is None else str(options.clips))


def clips_of_user(folder: str) -> dict[str, Clip]:
    """Kicks that can be played as the user, by name."""
    made, _ = synthetic_kicks(seed=_OTHER_SEED, takes=1)
    clips = [clip for clip in made if clip.name.startswith("kick")]
    if folder:
        clips = [*load_clips(folder)[0], *clips]
    return {clip.name: clip for clip in clips[:_MOST_CLIPS]}
