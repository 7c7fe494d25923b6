"""What can be measured in a scene, as JSON values."""

from __future__ import annotations

from typing import Any

import numpy as np

from mgjax.ballsport.aiming.solve import OK, STATUS_TEXT
from mgjax.ballsport.ball.physics import Net
from mgjax.ballsport.config import hit_bone
from mgjax.ballsport.scene.build import Scene
from mgjax.ballsport.scene.kick import kick_change
from mgjax.ballsport.scene.types import THROWN_IN, BallFlight, Touch
from mgjax.core.kinematics import joint_velocities

_TURN_RATE_S = 0.1
"""Turn rates are taken over so long, s, so that the sway of the hips in a step does not count."""


def scene_json(scene: Scene) -> dict[str, Any]:
    """The timeline: passes, throws, events, players, and the worst of everything."""
    flights = [_flight_json(scene, number, flight) for number, flight in enumerate(scene.flights)]
    passes = [row for number, row in enumerate(flights) if _is_pass(scene, number)]
    throws = [
        row
        for row, flight in zip(flights, scene.flights, strict=True)
        if flight.number == THROWN_IN
    ]
    players = [_player_json(scene, player.name) for player in scene.config.players]
    done = [row for row in passes if row["status"] == STATUS_TEXT[OK]]
    met = [*done, *throws]
    worst = {
        "arrival_miss_m": max(row["arrival_miss_m"] for row in met),
        "surface_gap_m": max(abs(row["surface_gap_m"]) for row in met),
        "time_warp": max((row["time_warp"] for row in met), key=lambda w: abs(w - 1)),
        "kick_change": max((row["kick_change"] for row in done), default=0.0),
        "link_distance_m": max(row["link_distance_m"] for row in met),
        "least_distance_to_others_m": min(
            (x for row in met if (x := row["distance_to_others_m"]) is not None), default=None
        ),
        "seam_speed_m_s": max(row["seam_speed_m_s"] for row in players),
        "turn_rate_deg_s": max(row["turn_rate_deg_s"] for row in players),
        "drift_m": max(row["drift_m"] for row in players),
    }
    changes = [row["kick_change"] for row in done]
    warps = [abs(row["time_warp"] - 1) for row in met]
    return {
        "seconds": len(scene.ball.places) / scene.frame_rate,
        "frame_rate": scene.frame_rate,
        "ball_radius_m": float(scene.config.physics.radius),
        "net": None if scene.config.net is None else _net_json(scene.config.net),
        "passes_made": len(done),
        "passes_missed": len(passes) - len(done),
        "mean_kick_change": float(np.mean(changes)) if changes else 0.0,
        "mean_time_warp_off": float(np.mean(warps)),
        "worst": worst,
        "passes": passes,
        "throws": throws,
        "players": players,
        "events": [
            {
                "t": event.time,
                "x": float(event.place[0]),
                "y": float(event.place[1]),
                "z": float(event.place[2]),
                "event": event.what,
                "player": event.who,
            }
            for event in scene.ball.events
        ],
        "notes": list(scene.moves.clips.notes),
    }


def _net_json(net: Net) -> dict[str, float]:
    return {name: float(getattr(net, name)) for name in ("x", "z", "heading", "height")}


def _is_pass(scene: Scene, number: int) -> bool:
    return scene.flights[number].number != THROWN_IN and bool(scene.ends[number][1])


def _flight_json(scene: Scene, number: int, flight: BallFlight) -> dict[str, Any]:
    rate, (by, to) = scene.frame_rate, scene.ends[number]
    row: dict[str, Any] = {
        "by": by,
        "to": to,
        "bounces": flight.bounces,
        "status": STATUS_TEXT[flight.status],
        "start_s": flight.start / rate,
        "arrives_s": flight.stop / rate,
        "flight_s": (flight.stop - flight.start) / rate,
        "ball_speed_m_s": float(np.linalg.norm(flight.velocity)),
        "place_m": flight.place.tolist(),
        "velocity_m_s": flight.velocity.tolist(),
        "target_m": flight.target.tolist(),
        "miss_m": flight.miss,
        "distance_to_others_m": _least_distance(scene, flight, {by, to}),
    }
    if flight.number != THROWN_IN:
        row = {"pass": flight.number + 1, **row, **_kick_json(scene, flight)}
    ended = [touch for touch in scene.touches if touch.time == flight.stop]
    if to and flight.status == OK and ended:
        row |= _touch_json(scene, ended[0])
        row["arrival_miss_m"] = float(np.linalg.norm(scene.ball.arrivals[number] - ended[0].centre))
    return row


def _kick_json(scene: Scene, flight: BallFlight) -> dict[str, Any]:
    """How the ball leaves, beside the bone that hits it."""
    touch = scene.touches[flight.number]
    ball, bone = flight.velocity, touch.bone
    speed = float(np.linalg.norm(bone))
    cosine = float(ball @ bone) / max(float(np.linalg.norm(ball)) * speed, 1e-9)
    clips = scene.moves.clips
    return {
        "kind": clips.hit_kind[touch.kick.hit],
        "bone": clips.hit_bone[touch.kick.hit],
        "clip": clips.clip_names[clips.hit_clip[touch.kick.hit]],
        "by_user": touch.by_user,
        "bone_speed_m_s": speed,
        "speed_ratio": float(np.linalg.norm(ball)) / max(speed, 1e-9),
        "angle_deg": float(np.degrees(np.arccos(np.clip(cosine, -1, 1)))),
        "kick_change": float(kick_change(ball[None], bone[None])[0]),
    }


def _touch_json(scene: Scene, touch: Touch) -> dict[str, Any]:
    """How the receiver meets the ball."""
    clips = scene.moves.clips
    joint = int(clips.hit_joint[touch.kick.hit])
    distance = float(
        np.linalg.norm(scene.positions[touch.player][touch.time, joint] - touch.centre)
    )
    reach = float(scene.config.physics.radius) + hit_bone(clips.hit_bone[touch.kick.hit]).radius_m
    return {
        "surface_gap_m": distance - reach,
        "contact_m": touch.centre.tolist(),
        "with": clips.hit_bone[touch.kick.hit],
        "time_warp": touch.warp,
        "link_distance_m": touch.cost,
    }


def _least_distance(scene: Scene, flight: BallFlight, out: set[str]) -> float | None:
    """From the ball's surface to the nearest joint of who takes no part; None: nobody is left."""
    others = [scene.positions[name] for name in scene.positions if name not in out]
    if not others:
        return None
    part = slice(flight.start, flight.stop + 1)
    ball = scene.ball.places[part][:, None]
    away = [np.linalg.norm(places[part] - ball, axis=-1).min() for places in others]
    return float(min(away)) - float(scene.config.physics.radius)


def _player_json(scene: Scene, name: str) -> dict[str, Any]:
    places, rate = scene.positions[name], scene.frame_rate
    home = next(player for player in scene.config.players if player.name == name)
    drift = np.hypot(places[:, 0, 0] - home.x, places[:, 0, 2] - home.z)
    speed = np.linalg.norm(np.asarray(joint_velocities(places, rate)), axis=-1).max(axis=1)
    inside = np.zeros(len(speed), bool)
    for start, stop in scene.seams[name]:
        inside[int(start * rate) : int(stop * rate) + 1] = True
    hips = [scene.skeleton.index(joint) for joint in ("lfemur", "rfemur")]
    across = places[:, hips[0]] - places[:, hips[1]]
    heading = np.unwrap(np.arctan2(-across[:, 2], across[:, 0]))
    step = max(1, round(_TURN_RATE_S * rate))
    turned = np.abs(heading[step:] - heading[:-step]).max(initial=0.0) * rate / step
    return {
        "name": name,
        "file": f"{name}.bvh",
        "x": home.x,
        "z": home.z,
        "touches": sum(touch.player == name for touch in scene.touches),
        "turns": [{"t": time, "degrees": angle} for time, angle in scene.turns[name]],
        "turn_rate_deg_s": float(np.degrees(turned)),
        "drift_m": float(drift.max()),
        "seams": len(scene.seams[name]),
        "seam_speed_m_s": float(speed[inside].max(initial=0.0)),
        "largest_speed_m_s": float(speed.max()),
    }
