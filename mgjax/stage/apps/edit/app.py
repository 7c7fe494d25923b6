"""The editor: clips, labels and graph of the folders given at start, or the embedded ones."""

from __future__ import annotations

from pathlib import Path

from mgjax.clips.synthetic import synthetic_clips
from mgjax.clips.types import Clip, Label, Labels
from mgjax.core.errors import ConfigError
from mgjax.core.motion import Motion
from mgjax.graph.files import FILE_NAME, load_graph
from mgjax.graph.types import MotionGraph
from mgjax.stage.apps.edit.labels import LabelBook
from mgjax.stage.apps.edit.library import Library, folder_library, memory_library
from mgjax.stage.apps.edit.picture import whole_labels
from mgjax.stage.apps.edit.session import EditSession
from mgjax.stage.apps.edit.workbench import Settings, Workbench
from mgjax.stage.serve.options import Options
from mgjax.stage.serve.session import Progress, Send, Session

EMBEDDED = Settings(threshold_m=0.05)
"""Of the embedded clips the automatic threshold leaves a handful of transitions."""
BUILD_AT_ONCE = 60
"""Graphs of more clips are built when they are asked for."""


def make_app(options: Options) -> EditApp:
    """The editor of the folders that were given."""
    return EditApp(options)


class EditApp:
    """What all tabs share."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._bench: Workbench | None = None

    def prepare(self, progress: Progress) -> None:
        """Lists the clips and reads labels and graph; clips are read while the page is used.

        Raises:
            MgjaxError: no clip, a labels file that is none, a damaged graph.
        """
        options = self._options
        progress(0.2, "looking for clips")
        graph = _graph(options.graph)
        library, given, path = _clips(options, graph)
        progress(0.6, "reading labels")
        book = LabelBook(library, path, given)
        settings = EMBEDDED if options.clips is None and graph is None else Settings()
        # Clips that only a graph holds are not written over it.
        folder = options.graph if options.clips is not None else None
        self._bench = Workbench(library, book, settings, folder)
        library.start()
        if graph is not None:
            self._bench.take_graph(graph, book.table.labels())
        elif len(library.names) <= BUILD_AT_ONCE:
            self._bench.build(settings, write=False)

    def open(self, send: Send) -> Session:
        """A new tab."""
        assert self._bench is not None
        return EditSession(self._bench, send)

    def close(self) -> None:
        """Ends the threads."""
        if self._bench is not None:
            self._bench.close()


def _graph(folder: Path | None) -> MotionGraph | None:
    """The graph in a folder; None where there is none yet."""
    if folder is None or not (folder / FILE_NAME).exists():
        return None
    return load_graph(folder)


def _clips(options: Options, graph: MotionGraph | None) -> tuple[Library, Labels, Path | None]:
    """The clips, the labels that memory holds, and the labels file."""
    if options.clips is not None:
        library = folder_library(options.clips)
        return library, {}, options.labels or options.clips / "labels.json"
    if options.labels is not None:
        raise ConfigError(got="--labels without --clips", expected="the clips' folder, too")
    if graph is not None:
        return memory_library(graph_clips(graph)), graph_labels(graph), None
    if options.graph is not None:
        raise ConfigError(got=f"no graph in {options.graph}", expected="one, or --clips as well")
    clips, labels = synthetic_clips()
    return memory_library(clips), labels, None


def graph_clips(graph: MotionGraph) -> list[Clip]:
    """The clips that a graph was built from, as it has them."""
    return [
        Clip(
            name=name,
            skeleton=graph.skeleton,
            motion=Motion(
                root_translation=graph.root_translation[a:b],
                local_rotations=graph.local_rotations[a:b],
                frame_rate=graph.frame_rate,
            ),
        )
        for name, a, b in zip(graph.clip_names, graph.clip_starts, graph.clip_stops, strict=True)
    ]


def graph_labels(graph: MotionGraph) -> dict[str, tuple[Label, ...]]:
    """The labels that a graph has kept, by clip."""
    found: dict[str, tuple[Label, ...]] = {}
    whole = whole_labels(graph).tolist()
    for part, (edge, (start, stop)) in enumerate(zip(graph.label_edge, whole, strict=True)):
        clip = int(graph.edge_clip[edge])
        first, name = int(graph.clip_starts[clip]), graph.clip_names[clip]
        label = Label(
            start_s=(start - first) / graph.frame_rate,
            end_s=(stop - first) / graph.frame_rate,
            kind=graph.label_kind[part],
            direction=graph.label_direction[part],
            genuine=bool(graph.label_genuine[part]),
        )
        found[name] = (*found.get(name, ()), label)
    return found
