"""All peers, and what each is asked to do."""

from __future__ import annotations

from functools import partial

from experiments.benchmarks.beside.ours import balls, bodies, chains, graphs
from experiments.benchmarks.beside.theirs import (
    fairmotion_graph,
    ikpy_chain,
    mink_hand,
    mujoco_ball,
    pyfabrik_chain,
    pymotion_kinematics,
    pyroki_hand,
    scipy_components,
)
from experiments.benchmarks.beside.types import Peer, Work

_HAND = "right hand to 1 mm, rotations, {} bones"
_CHAIN = "end of a chain to 1 mm, {}, {} links"

PEERS = (
    Peer(
        name="upc-pymotion",
        packages=("upc-pymotion==0.3.4",),
        theirs=pymotion_kinematics,
        works={
            f"{frames} frames": Work(
                words=f"forward kinematics, {frames} frames of a body of 38 joints",
                make=partial(bodies.kinematics, frames=frames),
            )
            for frames in (464, 1854)
        },
    ),
    Peer(
        name="fairmotion",
        packages=("numpy", "scipy", "networkx", "matplotlib", "tqdm"),
        alone=("fairmotion==0.0.4",),  # names a torch that no supported Python has
        theirs=fairmotion_graph,
        works={
            "graph": Work(
                words="motion graph of 250 frames", make=partial(bodies.graph, frames=250)
            )
        },
    ),
    Peer(
        name="pyfabrik",
        packages=("pyfabrik==0.4.0", "numpy<2"),
        theirs=pyfabrik_chain,
        works={
            f"{links} links": Work(
                words=_CHAIN.format("places of joints", links),
                make=partial(chains.points, links=links),
            )
            for links in (4, 8)
        },
    ),
    Peer(
        name="mink",
        packages=("mink==1.3.0", "mujoco==4.0.0", "daqp"),
        theirs=mink_hand,
        works={
            f"{bones} bones": Work(
                words=_HAND.format(bones), make=partial(chains.hand, bones=bones)
            )
            for bones in (4, 8)
        },
    ),
    Peer(
        name="pyroki",
        packages=("almond-pyroki==0.1.1",),
        theirs=pyroki_hand,
        works={
            f"{bones} bones{', together' if together else ''}": Work(
                words=_HAND.format(bones) + (", all targets in one call" if together else ""),
                make=partial(chains.hand, bones=bones, together=together),
            )
            for together in (False, True)
            for bones in (4, 8)
        },
    ),
    Peer(
        name="ikpy",
        packages=("ikpy==4.2.1",),
        theirs=ikpy_chain,
        works={
            f"{3 * links} degrees of freedom": Work(
                words=_CHAIN.format("rotations", links), make=partial(chains.angles, links=links)
            )
            for links in (4, 8)
        },
    ),
    Peer(
        name="mujoco + scipy",
        packages=("mujoco==4.0.0", "scipy"),
        theirs=mujoco_ball,
        works={
            name: Work(
                words=f"launch of a ball that is at a target in time, {name}",
                make=partial(balls.passes, bounces=bounces),
            )
            for bounces, name in enumerate(("no bounce", "one bounce"))
        },
    ),
    Peer(
        name="scipy.sparse.csgraph",
        present="scipy",
        theirs=scipy_components,
        works={
            "components": Work(
                words="which of 10000 transitions lie in the largest strong component",
                make=partial(graphs.components, nodes=10_000),
            )
        },
    ),
)
"""In the order of the results. mgjax asks scipy itself for strong components: there the ratio says
what it adds."""
