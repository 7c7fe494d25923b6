"""MuJoCo with SciPy: the launch of a ball fitted to its target by conjugate gradients."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls

STEP_S = 1 / 240
SPRING = 'solref="-20000 -32" friction="0 0 0" condim="1"'
"""A contact that gives back 0.7 of the speed: its damping is 0.11 of the critical."""


def set_up(
    start: Any, targets: Any, guesses: Any, duration: float, gravity: float, radius: float
) -> Calls:
    """Slopes are finite differences of whole flights."""
    import mujoco  # pyright: ignore[reportMissingImports]
    from scipy.optimize import minimize

    place = " ".join(str(x) for x in start)
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP_S}" gravity="0 {-gravity} 0"/><worldbody>'
        f'<geom type="plane" size="50 50 1" zaxis="0 1 0" {SPRING}/>'
        f'<body pos="{place}"><freejoint/>'
        f'<geom type="sphere" size="{radius}" mass="0.43" {SPRING}/></body></worldbody></mujoco>'
    )
    state = mujoco.MjData(model)
    steps = round(duration / STEP_S)
    wanted = np.array(targets)

    def fly(velocity: Any) -> np.ndarray:
        mujoco.mj_resetData(model, state)
        state.qvel[:3] = velocity
        for _ in range(steps):
            mujoco.mj_step(model, state)
        return state.qpos[:3].copy()

    def call(number: int) -> Any:
        def off(velocity: Any) -> float:
            return float(np.sum((fly(velocity) - wanted[number]) ** 2))

        return minimize(off, guesses[number], method="CG", options={"gtol": 1e-6}).x

    def miss(number: int, velocity: Any) -> float:
        return float(np.linalg.norm(fly(velocity) - wanted[number]))

    return Calls(count=len(targets), call=call, miss=miss)
