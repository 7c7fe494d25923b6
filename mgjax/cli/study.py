"""``mgjax study export`` and ``mgjax study score``."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mgjax.avoidance.config import AvoidanceConfig, validate_config
from mgjax.avoidance.prepared import prepared_for
from mgjax.avoidance.study.format import key_json
from mgjax.avoidance.study.reading import read_study
from mgjax.avoidance.study.report import report
from mgjax.avoidance.study.trials import make_trials
from mgjax.cli.arguments import Export, Score, Study
from mgjax.cli.report import emit, to_json
from mgjax.core.errors import ConfigError
from mgjax.graph.files import load_graph
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config, to_toml
from mgjax.stage.observers import write_observers


def run(command: Study) -> None:
    """Writes trials, or reads picks."""
    if isinstance(command.action, Export):
        export(command.action)
    else:
        score(command.action)


def export(command: Export) -> None:
    """Writes ``key.json``, and beside it the folder that observers get."""
    if (command.out / "for_observers").exists():
        raise ConfigError(
            got=f"{command.out}, which has a study", expected="a folder of its own for each"
        )
    config = load_config(command.config, AvoidanceConfig) if command.config else AvoidanceConfig()
    config = replace(config, refine="off")
    validate_config(config)
    graph = load_graph(command.graph)
    with output_folder(command.out) as folder:
        trials = make_trials(
            prepared_for(graph, config),
            command.trials,
            config=config,
            seed=command.seed,
            most=command.candidates,
        )
        key = key_json(graph, config, trials)
        (folder / "key.json").write_text(to_json(key) + "\n")
        write_observers(folder / "for_observers", graph.skeleton, key["study"], trials)
    ways = sum(len(trial.ways) for trial in trials)
    result = {"study": key["study"], "trials": len(trials), "candidates": ways}
    lines = [
        f"{len(trials)} trials, {ways} candidates",
        f"for observers: {command.out / 'for_observers' / 'index.html'}",
        f"for you alone: {command.out / 'key.json'}",
    ]
    emit(result, lines, as_json=command.json)


def score(command: Score) -> None:
    """Prints what the picks say."""
    if not command.files:
        raise ConfigError(got="no files", expected="key.json and files of picks")
    result, config = report(read_study(command.files))
    if command.out is not None:
        with output_folder(command.out) as folder:
            (folder / "score.json").write_text(to_json(result) + "\n")
            if config is not None:
                (folder / "energy.toml").write_text("[energy]\n" + to_toml(config))
    lines = [*describe(result), *([f"written to {command.out}"] if command.out else [])]
    emit(result, lines, as_json=command.json)


def describe(result: dict[str, Any]) -> list[str]:
    """For people: agreement, then what was fitted."""
    lines = [_agreement("all picks", result["agreement"])]
    if len(result["observers"]) > 1:
        lines += [_agreement(name, row) for name, row in result["observers"].items()]
    between = result["between_observers"]
    if between is not None:
        low, high = between["interval"]
        lines.append(
            f"between observers: {between['share']:.0%} ({low:.0%} … {high:.0%}) on"
            f" {between['trials']} trials, kappa {between['kappa']:.2f}"
        )
        lines += [
            f"  {' and '.join(row['observers'])}: {row['share']:.0%} of {row['trials']},"
            f" kappa {row['kappa']:.2f}"
            for row in (between["pairs"] if len(between["pairs"]) > 1 else [])
        ]
    return [*lines, *_fit(result["fit"])]


def _agreement(name: str, row: dict[str, Any]) -> str:
    low, high = row["interval"]
    return (
        f"{name}: the search agrees with {row['share']:.0%} ({low:.0%} … {high:.0%}) of"
        f" {row['picks']} picks in {row['trials']} trials, chance {row['chance']:.0%}"
    )


def _fit(fit: dict[str, Any]) -> list[str]:
    if fit["status"] != "fitted":
        return [f"{fit['status']}: {fit['why']}"]
    lines = [
        f"fitted: agrees with {fit['agreement']:.0%}, with {fit['held_out_agreement']:.0%} of picks"
        f" held out; better than chance with p = {fit['p']:.3f}",
        f"{'':12} {'fitted':>9}   {'95 %':<17} {'as a setting':>12}",
    ]
    for name, row in fit["parameters"].items():
        low = "0" if row["low"] is None else f"{row['low']:.3g}"
        high = "∞" if row["high"] is None else f"{row['high']:.3g}"
        ends = f"{low} … {high}" if row["fitted"] else "these trials do not tell"
        lines.append(f"{name:12} {row['value']:9.3g}   {ends:<17} {fit['settings'][name]:12.3g}")
    return lines
