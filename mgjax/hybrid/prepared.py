"""What walking and reaching need of a graph, computed once and passed down explicitly."""

from __future__ import annotations

import weakref
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool

from mgjax.core.body.capsules import Capsules, make_capsules
from mgjax.core.errors import ConfigError
from mgjax.core.skeleton import Skeleton
from mgjax.graph.cache import cached
from mgjax.graph.plants import planted_frames
from mgjax.graph.types import MotionGraph
from mgjax.hybrid.body.limb_limits import LimbLimits, make_limb_limits
from mgjax.hybrid.body.rig import LimbRig, make_limb_rig
from mgjax.hybrid.config import ReachConfig
from mgjax.hybrid.ik.limbs import Limb
from mgjax.hybrid.macro.macro_edges import MacroEdges, build_macro_edges


@dataclass(frozen=True, kw_only=True, eq=False)
class ReachBody:
    """The body as reaching reads it.

    Attributes:
        skeleton: its joints.
        scale: how large it is; see :func:`mgjax.core.body.height.body_scale`.
        capsules: its surface.
        limits: how far the joints of its limbs turn; None where reaches keep no limits.
    """

    skeleton: Skeleton
    scale: float
    capsules: Capsules
    limits: LimbLimits | None

    def rig(self, limbs: tuple[Limb, ...], config: ReachConfig) -> LimbRig:
        """What moves in a reach of limbs, with their limits where the settings ask for them."""
        limits = self.limits.of(limbs) if config.limits and self.limits is not None else None
        return make_limb_rig(self.skeleton, limbs, limits)


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """The state of the hybrid room for one graph; it does not keep the graph alive.

    Attributes:
        graph: what it was computed from, weakly.
        macro_edges: what the path search extends walks by.
        plants: in which frames of the graph the left and the right foot stand still. [F, 2]
        body: for :func:`mgjax.hybrid.reach`; None where it is prepared for walking alone.
    """

    graph: weakref.ref[MotionGraph]
    macro_edges: MacroEdges
    plants: Bool[np.ndarray, "F 2"]
    body: ReachBody | None

    @property
    def reach_body(self) -> ReachBody:
        """The body; :class:`ConfigError` where it is prepared for walking alone."""
        if self.body is None:
            raise ConfigError(
                got="the state prepared for walking alone",
                expected="that of prepare(graph, config)",
            )
        return self.body


def prepare(graph: MotionGraph, config: ReachConfig | None = None) -> Prepared:
    """Computes what :func:`mgjax.hybrid.follow` and :func:`mgjax.hybrid.reach` need of a graph.

    Args:
        graph: with locomotion.
        config: settings of the reaches; None for :func:`mgjax.hybrid.follow` alone.

    Raises:
        GraphError: no walk of the graph gets anywhere.
        SkeletonError: a skeleton without hands or head, with ``config``.
    """
    return Prepared(
        graph=weakref.ref(graph),
        macro_edges=build_macro_edges(graph),
        plants=planted_frames(graph),
        body=None if config is None else _prepare_body(graph, config),
    )


def prepared_for(
    graph: MotionGraph, config: ReachConfig | None = None, prepared: Prepared | None = None
) -> Prepared:
    """The state that was passed, or else that of the library's cache.

    Args:
        graph, config: as for :func:`prepare`.
        prepared: state that was passed.

    Raises:
        ConfigError: ``prepared`` belongs to another graph, or lacks what ``config`` needs.
        GraphError, SkeletonError: as :func:`prepare`.
    """
    if prepared is not None:
        _check(graph, config, prepared)
        return prepared
    walking = cached(graph, ("hybrid", "walking"), lambda: prepare(graph))
    if config is None:
        return walking
    key = ("hybrid", "body", config.limits)
    return replace(walking, body=cached(graph, key, lambda: _prepare_body(graph, config)))


def _prepare_body(graph: MotionGraph, config: ReachConfig) -> ReachBody:
    return ReachBody(
        skeleton=graph.skeleton,
        scale=graph.body_scale,
        capsules=make_capsules(graph.skeleton),
        limits=make_limb_limits(graph) if config.limits else None,
    )


def _check(graph: MotionGraph, config: ReachConfig | None, prepared: Prepared) -> None:
    if prepared.graph() is not graph:
        raise ConfigError(got="the state prepared for another graph", expected="this graph's")
    if config is None:
        return
    if config.limits and prepared.reach_body.limits is None:
        raise ConfigError(
            got="the state prepared for reaches without limits",
            expected="that of prepare(graph, config)",
        )
