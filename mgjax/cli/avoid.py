"""``mgjax avoid``."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from mgjax.avoidance.attacks.attack import Attack
from mgjax.avoidance.attacks.ball import ball_attack
from mgjax.avoidance.attacks.json_file import load_attack
from mgjax.avoidance.body.spheres import preset_spheres
from mgjax.avoidance.choice.compile_ahead import compile_for
from mgjax.avoidance.choice.selection import Selection, both_timings, select
from mgjax.avoidance.config import AvoidanceConfig
from mgjax.avoidance.index.files import FILE_NAME, load_index
from mgjax.avoidance.parry.guard import guard_of
from mgjax.avoidance.parry.parry import Parry
from mgjax.avoidance.rates import EXPORT_RATE
from mgjax.avoidance.refinement.refinement import Refinement
from mgjax.avoidance.timing.walk_warps import natural_starts, part_moments, speed_change
from mgjax.cli.arguments import Avoid
from mgjax.cli.report import emit, seams_json, to_json
from mgjax.core.errors import ConfigError
from mgjax.graph.files import load_graph
from mgjax.graph.types import NO_CLIP, MotionGraph
from mgjax.io.bvh.write import save_bvh
from mgjax.io.output import output_folder
from mgjax.io.toml_file import load_config
from mgjax.pictures.throws import Throw, scene_picture
from mgjax.stage.html import save_html


def run(command: Avoid) -> None:
    """Throws a ball, or what a file says, and writes what came of it.

    Where the folder of the graph has an index, candidates are looked up in it.
    """
    if command.seed < 0:
        raise ConfigError(got=f"seed {command.seed}", expected="0 or more")
    config = load_config(command.config, AvoidanceConfig) if command.config else AvoidanceConfig()
    graph = load_graph(command.graph)
    stored = (Path(command.graph) / FILE_NAME).exists()
    index = load_index(command.graph, graph) if stored else None
    node = command.node
    if node is None:
        node = int(np.random.default_rng(command.seed).integers(graph.num_nodes))
    attack = attack_of(command)
    with output_folder(command.out) as folder:
        compile_for(graph, node, attack, config=config, index=index)
        selection = select(graph, node, attack, config=config, seed=command.seed, index=index)
        note = guard_of(graph).note if config.parry == "on" else None
        result = selection_json(graph, selection) | {"notes": [] if note is None else [note]}
        (folder / "result.json").write_text(to_json(result) + "\n")
        save_bvh(folder / "motion.bvh", graph.skeleton, selection.motion)
        write_volumes(folder / "volumes.npz", graph, attack, selection)
        shown = attack if selection.parry is None else selection.parry.left_of(attack)
        scene_picture(folder / "scene.png", graph, [Throw(attack=shown, selection=selection)])
        if command.html:
            save_html(folder / "index.html", selection)
    lines = [describe(graph, selection), *result["notes"], f"written to {command.out}"]
    emit(result, lines, as_json=command.json)


def attack_of(command: Avoid) -> Attack:
    """The attack of a file, or the ball that the arguments describe.

    Raises:
        ConfigError: both, or a ball that is not fully described.
        FileFormatError, AttackError: it is no attack.
    """
    start, at, speed, arrives = command.start, command.at, command.speed, command.arrives
    ball = {"--from": start, "--at": at, "--speed": speed, "--arrives": arrives}
    if command.attack is not None:
        extra = [name for name, value in ball.items() if value is not None]
        extra += ["--gravity"] if command.gravity else []
        extra += ["--radius"] if command.radius != Avoid.radius else []
        if extra:
            raise ConfigError(
                got=f"--attack beside {', '.join(extra)}", expected="only one of both"
            )
        return load_attack(command.attack)
    if start is None or at is None or speed is None or arrives is None:
        missing = ", ".join(name for name, value in ball.items() if value is None)
        raise ConfigError(got=f"no {missing}", expected=f"{', '.join(ball)}, or --attack")
    return ball_attack(
        np.array(start),
        np.array(at),
        speed=speed,
        arrives=arrives,
        gravity=command.gravity,
        radius=command.radius,
    )


def selection_json(graph: MotionGraph, selection: Selection) -> dict[str, Any]:
    """The answer to an attack as JSON values.

    ``start_s`` and ``end_s`` of an edge are seconds from now; ``clip`` is the clip it plays, or the
    two that it blends, and ``clip_start_s`` … ``clip_end_s`` what it plays of it; ``scale`` is how
    long it is played, divided by its natural duration, so with a smooth warp the mean over it.
    ``time_scale`` is that of eq. 3. ``seams`` are the transitions in the written motion.
    """
    chosen = selection
    crop = chosen.crop
    starts = np.asarray(chosen.timing.when(natural_starts(graph, chosen.walk)))
    length = (chosen.motion.num_frames - 1) / EXPORT_RATE
    return {
        "status": chosen.status,
        "node": chosen.node,
        "candidates": chosen.candidates,
        "dropped": dataclasses.asdict(chosen.dropped),
        "walk": _walk_json(graph, selection),
        "seams": seams_json(graph, chosen.walk.edges, starts, length),
        "time_scale": chosen.time_scale,
        "warp": _warp_json(graph, selection),
        "part": None if chosen.part is None else _part_json(graph, selection, chosen.part),
        "energy": None if chosen.energy is None else dataclasses.asdict(chosen.energy),
        "clearance_m": chosen.clearance_m,
        "clear_until": chosen.clear_until,
        "refinement": None if chosen.refinement is None else refinement_json(chosen.refinement),
        "parry": None if chosen.parry is None else parry_json(chosen.parry),
        "attack": None
        if crop is None
        else {"crop_start_s": crop.start, "crop_end_s": crop.end, "t_attack": crop.middle},
    }


def refinement_json(change: Refinement) -> dict[str, Any]:
    """How a motion was changed as JSON values: when, and how far each joint at most."""
    rows = zip(change.joints, change.moved_m, change.turned_deg, strict=True)
    return {
        "start_s": change.start,
        "end_s": change.stop,
        "clearance_before_m": change.clearance_before_m,
        "shift_s": change.shift_s,
        "largest_m": change.largest_m,
        "largest_deg": change.largest_deg,
        "joints": {name: {"moved_m": m, "turned_deg": deg} for name, m, deg in rows},
    }


def parry_json(parry: Parry) -> dict[str, Any]:
    """How an arm meets an attack as JSON values: with what, when, where, and by what change."""
    rows = zip(parry.joints, parry.moved_m, parry.turned_deg, strict=True)
    return {
        "limb": parry.limb,
        "time_s": parry.time,
        "place_m": parry.place.tolist(),
        "sphere": parry.sphere,
        "square": parry.square,
        "start_s": parry.start,
        "end_s": parry.stop,
        "clearance_before_m": parry.clearance_before_m,
        "largest_cm": 100 * parry.largest_m,
        "largest_deg": parry.largest_deg,
        "joints": {name: {"moved_cm": 100 * m, "turned_deg": deg} for name, m, deg in rows},
    }


def _walk_json(graph: MotionGraph, selection: Selection) -> list[dict[str, Any]]:
    walk = selection.walk
    natural = natural_starts(graph, walk)
    starts = np.asarray(selection.timing.when(natural))
    scales = np.diff(starts) / np.diff(natural)
    rows: list[dict[str, Any]] = []
    for i, edge in enumerate(walk.edges):
        clip = int(graph.edge_clip[edge])
        row: dict[str, Any] = {"edge": int(edge)}
        if clip == NO_CLIP:
            ends = (
                graph.node_clip[graph.edge_source[edge]],
                graph.node_clip[graph.edge_target[edge]],
            )
            row["clip"] = " > ".join(graph.clip_names[int(c)] for c in ends)
        else:
            row["clip"] = graph.clip_names[clip]
        row |= {"start_s": float(starts[i]), "end_s": float(starts[i + 1])}
        row |= {"scale": float(scales[i]), "path": i < selection.path_length}
        if clip != NO_CLIP:
            frames = np.array([graph.edge_starts[edge], graph.edge_stops[edge]])
            seconds = (frames - graph.clip_starts[clip]) / graph.frame_rate
            row |= {"clip_start_s": float(seconds[0]), "clip_end_s": float(seconds[1])}
        rows.append(row)
    return rows


def _warp_json(graph: MotionGraph, selection: Selection) -> dict[str, Any]:
    """How the walk is played, and how abruptly its speed changes in both forms.

    ``speed_change_per_s`` is the largest difference between the playback speeds (1 is natural) at
    two frames of the written motion that follow one another, divided by the time between them; what
    comes before now counts as natural. ``speed`` has the least and the largest speed at a frame.
    ``t_avoid`` is when the middle of the avoidance part is shown, s from now.
    """
    times = np.arange(selection.motion.num_frames) / EXPORT_RATE
    speeds = selection.timing.speed(times)
    linear, smooth = both_timings(graph, selection)
    result: dict[str, Any] = {
        "form": selection.warp,
        "speed": [float(speeds.min()), float(speeds.max())],
        "speed_change_per_s": {
            "smooth": speed_change(smooth, float(times[-1]), EXPORT_RATE),
            "linear": speed_change(linear, float(times[-1]), EXPORT_RATE),
        },
        "t_avoid": None,
    }
    if selection.part is not None:
        moments = part_moments(graph, selection.walk, selection.path_length, selection.part)
        result["t_avoid"] = float(selection.timing.when(moments[1:2])[0])
    return result


def _part_json(graph: MotionGraph, selection: Selection, part: int) -> dict[str, Any]:
    """The avoidance part, and when the motion shows it, s from now."""
    captured = part_moments(graph, selection.walk, selection.path_length, part)
    start, _, end = selection.timing.when(captured).tolist()
    return {
        "start_s": start,
        "end_s": end,
        "index": part,
        "kind": graph.label_kind[part],
        "direction": graph.label_direction[part],
        "genuine": bool(graph.label_genuine[part]),
    }


def write_volumes(path: Path, graph: MotionGraph, attack: Attack, selection: Selection) -> None:
    """Attack and body over time, as they were checked.

    A sphere that is not there is put 1 km away, back or on along its flight, so that every distance
    stays a number and whoever joins the moments by lines does not draw one through the body. One
    that is parried is not there from the contact on.
    """
    if selection.parry is not None:
        attack = selection.parry.left_of(attack)
    trace = selection.trace
    centres = attack.at(trace.times)
    still = np.array([0.0, -1.0, 0.0])
    for sphere, (start, stop) in enumerate(zip(*attack.lifetimes, strict=True)):
        knots = attack.centres[(attack.times >= start) & (attack.times <= stop), sphere]
        for absent, end, inner in (
            (trace.times < start - 1e-9, knots[0], knots[min(1, len(knots) - 1)]),
            (trace.times > stop + 1e-9, knots[-1], knots[-min(2, len(knots))]),
        ):
            length = np.linalg.norm(end - inner, axis=-1)
            direction = (end - inner) / length if length > 1e-9 else still
            centres[absent, sphere] = end + 1000.0 * direction
    np.savez_compressed(
        path,
        times=trace.times,
        attack_centres=centres,
        attack_radii=attack.radii,
        body_centres=trace.centres,
        body_radii=preset_spheres(graph.skeleton).radii,
    )


def describe(graph: MotionGraph, selection: Selection) -> str:
    """One line for people."""
    chosen = selection
    if chosen.status == "no_candidate":
        return f"no candidate ({chosen.candidates} walks, dropped {chosen.dropped})"
    if chosen.parry is not None:
        parry = chosen.parry
        return (
            f"parried with the {parry.limb.replace('_', ' ')} at {parry.time:.2f} s, led by"
            f" {100 * parry.largest_m:.0f} cm and {parry.largest_deg:.0f}°;"
            f" nothing avoids it among {chosen.candidates} candidates"
        )
    kind, side = graph.label_kind[chosen.part or 0], graph.label_direction[chosen.part or 0]
    change = chosen.refinement
    changed = ""
    if change is not None:
        changed = f", changed by {100 * change.largest_m:.1f} cm and {change.largest_deg:.0f}°"
        if change.shift_s:
            way = "later" if change.shift_s > 0 else "earlier"
            changed += f", {abs(change.shift_s):.2f} s {way}"
    return (
        f"{chosen.status} by {kind} {side}".rstrip()
        + f", clearance {chosen.clearance_m:.3f} m, time scale {chosen.time_scale:.2f},"
        f" best of {chosen.candidates} candidates{changed}"
    )
