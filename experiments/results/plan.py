"""Which experiments are run at full size, in which order, on which capture."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class Planned:
    """One run of an experiment.

    Attributes:
        experiment: room and script.
        settings: beside those of its file in ``configs``, if it has one.
        clips: folder below that of the capture; "" where none is needed.
        name: of its record, where one experiment is run more than once.
    """

    experiment: str
    settings: tuple[str, ...] = ()
    clips: str = ""
    name: str = ""

    @property
    def record(self) -> str:
        """Name of its record, without suffix."""
        return self.name or self.experiment.replace("/", "_")

    def words(self, root: Path, capture: Path | None, out: Path) -> list[str]:
        """The arguments of the script."""
        file = root / "configs" / f"{self.experiment}.toml"
        words = ["--config", str(file)] if file.is_file() else []
        if self.clips and capture is not None:
            words += ["--set", f"clips={capture / self.clips}"]
        for setting in self.settings:
            words += ["--set", setting]
        words += ["--out", str(out / self.record)]
        return [*words, "--record", str(out / "records" / f"{self.record}.json")]


AVOIDANCE, BALL, WALKS = "avoidance", "ball", "locomotion/cmu16"

PLAN = (
    Planned(experiment="avoidance/table1", clips=AVOIDANCE, settings=("repeats=3",)),
    Planned(experiment="benchmarks/distances"),
    Planned(experiment="benchmarks/energy"),
    Planned(experiment="benchmarks/fabrik"),
    Planned(experiment="benchmarks/grid_index", clips=AVOIDANCE),
    Planned(experiment="benchmarks/random_attacks", settings=("attacks=2000",)),
    Planned(experiment="benchmarks/planner", clips=AVOIDANCE, settings=("minutes=3",)),
    Planned(experiment="benchmarks/peers"),
    Planned(experiment="hybrid/build", clips=WALKS),
    Planned(experiment="hybrid/follow", clips=WALKS),
    Planned(experiment="hybrid/reach", clips=WALKS),
    Planned(experiment="ballsport/analysis", clips=BALL),
    Planned(experiment="ballsport/aim"),
    Planned(experiment="ballsport/scene"),
    Planned(experiment="ballsport/matching", clips=BALL),
    Planned(experiment="avoidance/culling", clips=AVOIDANCE, settings=("balls=100",)),
    Planned(experiment="avoidance/refining", clips=AVOIDANCE, settings=("balls=200", "strips=4")),
    Planned(experiment="avoidance/warp", clips=AVOIDANCE),
    Planned(experiment="avoidance/parry", clips=AVOIDANCE),
    Planned(experiment="avoidance/minimal_movement", clips=AVOIDANCE, settings=("balls=200",)),
    Planned(experiment="avoidance/sweep", clips=AVOIDANCE, settings=("balls=100",)),
    Planned(experiment="avoidance/reaction_time", clips=AVOIDANCE, settings=("balls=100",)),
    Planned(experiment="avoidance/calibrate", clips=AVOIDANCE, settings=("balls=100",)),
    Planned(experiment="quality/blends", clips=AVOIDANCE, settings=("most=300", "seams=1000")),
    Planned(experiment="quality/seams", clips=AVOIDANCE, settings=("walks=1000",)),
    Planned(experiment="avoidance/success", clips=AVOIDANCE, settings=("balls=50",)),
    Planned(
        experiment="avoidance/connectivity",
        clips=AVOIDANCE,
        settings=("balls=100", "nodes=24", "thresholds_m=[0, 0.16]"),
    ),
)
"""What measures time first, while nothing else was begun beside it. The settings are what a busy
core of two does in hours that are to be had; records say them."""
