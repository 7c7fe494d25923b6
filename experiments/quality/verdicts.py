"""Whether generated motion is as good as uncut motion: the goals, and a blind test."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.stats import rankdata

from mgjax.quality.result import percentiles
from mgjax.quality.speeds import hellinger

BLIND = (
    *("skate_ratio", "contact_speed", "skate_cm", "normalised_jerk", "jerk_ratio"),
    *("velocity_jump", "sink", "floating", "self_penetration", "limits"),
)
"""Measures by which seams may give themselves away."""
DEPTH_M, SINK_M, SKATE, JERKY, AUC, SPEEDS, ANGLES = 0.01, 0.005, 0.005, 0.005, 0.55, 0.05, 5.0
"""What the goals allow."""
LENIENCE = 1.1
FINEST = {"sink": 1e-4, "floating": 1e-4, "self_penetration": 1e-4, "limits": 0.01}
"""Steps in which measures are told apart in the blind test: 0.1 mm, 0.01°. Less is rounding."""


def row_of(
    name: str,
    made: tuple[Mapping[str, np.ndarray], np.ndarray],
    uncut: tuple[Mapping[str, np.ndarray], np.ndarray],
) -> dict[str, Any]:
    """Median and 95th percentile of each measure beside those of uncut motion, and the goals.

    Args:
        name: of what was made.
        made, uncut: figures and histograms of joint speeds; see
            :func:`mgjax.quality.measure_many`.
    """
    values, own = made[0], uncut[0]
    row: dict[str, Any] = {"name": name, "pieces": len(values["sink"]), "uncut": len(own["sink"])}
    for key in values:
        row[f"{key}_p50_p95"] = percentiles(values[key])
        row[f"{key}_uncut_p50_p95"] = percentiles(own[key])
    row["auc"] = {key: auc(own[key], values[key], FINEST.get(key, 0.0)) for key in BLIND}
    row["best_auc"] = max(row["auc"].values())
    for key in ("skate_ratio", "jerky", "contact_speed", "contact_fast"):
        row[f"{key}_mean"], row[f"{key}_mean_uncut"] = np.nanmean(values[key]), np.nanmean(own[key])
    for key, most in (("sink", SINK_M), ("self_penetration", DEPTH_M), ("limits", ANGLES)):
        row[f"{key}_above"], row[f"{key}_above_uncut"] = (
            float((x[key] > most).mean()) for x in (values, own)
        )
        row[f"{key}_most"] = float(np.nanmax(values[key]))
    row["speed_distance"] = float(np.asarray(hellinger(made[1], uncut[1])).mean())
    return row | {"goals": goals_of(row)}


def goals_of(row: Mapping[str, Any]) -> dict[str, bool]:
    """Which goals are met."""

    def near(key: str) -> bool:
        pairs = zip(row[f"{key}_p50_p95"], row[f"{key}_uncut_p50_p95"], strict=True)
        return all(made <= LENIENCE * own for made, own in pairs)

    return {
        "G1 skate ratio": bool(row["skate_ratio_mean"] <= SKATE),
        "G1 contact speed": near("contact_speed"),
        "G1 skate": near("skate_cm"),
        "G2": bool(row["jerky_mean"] <= JERKY),
        "G3 sink": bool(row["sink_most"] <= SINK_M),
        "G3 depth": bool(row["self_penetration_most"] <= DEPTH_M),
        "G4": bool(row["best_auc"] <= AUC),
        "G5 speeds": bool(row["speed_distance"] <= SPEEDS),
        "G5 limits": bool(row["limits_most"] <= ANGLES),
    }


def auc(uncut: np.ndarray, made: np.ndarray, finest: float = 0.0) -> float:
    """How well a measure tells made from uncut motion: 0.5 not at all, 1 always.

    Pieces that show nothing of the kind are left out; 0.5 where either has none that does.
    """
    uncut, made = uncut[np.isfinite(uncut)], made[np.isfinite(made)]
    if finest:
        uncut, made = np.round(uncut / finest), np.round(made / finest)
    if not len(uncut) or not len(made):
        return 0.5
    ranks = rankdata(np.concatenate([uncut, made]))[len(uncut) :].sum()
    area = (ranks - len(made) * (len(made) + 1) / 2) / (len(uncut) * len(made))
    return float(max(area, 1 - area))


def line_of(row: Mapping[str, Any]) -> list[str]:
    """What is printed of a row."""
    met = [name for name, ok in row["goals"].items() if ok]
    missed = [name for name, ok in row["goals"].items() if not ok]
    best = max(row["auc"], key=row["auc"].get)
    lines = [f"{row['name']}: {row['pieces']} pieces beside {row['uncut']} uncut"]
    for key in (*BLIND, "contact_fast", "jerky"):
        (a, b), (c, d) = row[f"{key}_p50_p95"], row[f"{key}_uncut_p50_p95"]
        area = f"  AUC {row['auc'][key]:.2f}" if key in row["auc"] else ""
        lines.append(f"  {key:18} {a:9.4f} {b:9.4f}   uncut {c:9.4f} {d:9.4f}{area}")
    lines += [
        f"  skating {row['skate_ratio_mean']:.4f} (uncut {row['skate_ratio_mean_uncut']:.4f}),"
        f" jerky {row['jerky_mean']:.3%} (uncut {row['jerky_mean_uncut']:.3%}),"
        f" speeds apart {row['speed_distance']:.3f}, best AUC {row['best_auc']:.2f} ({best})",
        f"  sink above 5 mm {row['sink_above']:.1%} (uncut {row['sink_above_uncut']:.1%}), limbs"
        f" above 1 cm {row['self_penetration_above']:.2%}"
        f" (up to {100 * row['self_penetration_most']:.1f} cm),"
        f" angles above 5° {row['limits_above']:.2%} (up to {row['limits_most']:.1f}°)",
        f"  met: {', '.join(met) or 'none'}; missed: {', '.join(missed) or 'none'}",
    ]
    return lines
