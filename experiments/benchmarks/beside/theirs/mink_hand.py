"""mink: a hand brought to a target by steps of differential inverse kinematics."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls

STEPS = 200


def set_up(offsets: Any, targets: Any, tolerance: float) -> Calls:
    """Ball joints, a task of position alone, steps until the hand is there."""
    import mink  # pyright: ignore[reportMissingImports]
    import mujoco  # pyright: ignore[reportMissingImports]

    model = mujoco.MjModel.from_xml_string(_body(offsets))
    wanted = np.array(targets)

    def before(number: int) -> Any:
        pose = mink.Configuration(model)
        pose.update(np.array(model.qpos0))
        task = mink.FrameTask(
            "end", "body", position_cost=1.0, orientation_cost=0.0, lm_damping=1e-3
        )
        task.set_target(mink.SE3.from_translation(wanted[number]))
        return pose, task, wanted[number]

    def call(given: Any) -> Any:
        pose, task, target = given
        end = pose.data.body("end").xpos
        for _ in range(STEPS):
            way = mink.solve_ik(pose, [task], 1.0, "daqp", damping=1e-6, limits=[])
            pose.integrate_inplace(way, 1.0)
            end = pose.data.body("end").xpos
            if np.linalg.norm(end - target) <= tolerance:
                break
        return np.array(end)

    def miss(number: int, end: Any) -> float:
        return float(np.linalg.norm(end - wanted[number]))

    return Calls(count=len(targets), call=call, miss=miss, before=before)


def _body(offsets: Any) -> str:
    """The chain as MuJoCo reads it, the end without a joint."""
    text = ""
    for number in reversed(range(len(offsets))):
        last = number == len(offsets) - 1
        name, joint = ("end", "") if last else (f"bone{number}", '<joint type="ball"/>')
        place = " ".join(f"{x:.9f}" for x in offsets[number])
        ball = '<geom type="sphere" size="0.02" mass="0.1" contype="0" conaffinity="0"/>'
        text = f'<body name="{name}" pos="{place}">{joint}{ball}{text}</body>'
    return f'<mujoco><option gravity="0 0 0"/><worldbody>{text}</worldbody></mujoco>'
