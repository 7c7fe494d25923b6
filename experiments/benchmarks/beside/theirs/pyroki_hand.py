"""pyroki: a hand brought to a target by compiled least squares."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from experiments.benchmarks.beside.calls import Calls

AXES = ("1 0 0", "0 1 0", "0 0 1")


def set_up(offsets: Any, targets: Any, tolerance: float, together: bool = False) -> Calls:
    """Each ball joint is three hinges; position alone counts. One by one, or all in one call.

    The solver's settings are those of its own example; it takes no tolerance.
    """
    import jax  # the peer's own
    import jax.numpy as jnp
    import jaxlie  # pyright: ignore[reportMissingImports]
    import jaxls  # pyright: ignore[reportMissingImports]
    import pyroki  # pyright: ignore[reportMissingImports]
    import yourdfpy  # pyright: ignore[reportMissingImports]

    file = io.BytesIO(_robot(offsets).encode())
    robot = pyroki.Robot.from_urdf(yourdfpy.URDF.load(file))
    end = jnp.array(robot.links.names.index("end"))
    wanted = np.array(targets, np.float32)

    def solve(place: Any) -> Any:
        joints = robot.joint_var_cls(0)
        pose = jaxlie.SE3.from_rotation_and_translation(jaxlie.SO3.identity(), place)
        costs = [
            pyroki.costs.pose_cost_analytic_jac(
                robot, joints, pose, end, pos_weight=50.0, ori_weight=0.0
            ),
            pyroki.costs.limit_cost(robot, joints, weight=100.0),
            pyroki.costs.rest_cost(joints, rest_pose=joints.default_factory(), weight=1e-3),
        ]
        solved = (
            jaxls.LeastSquaresProblem(costs, [joints])
            .analyze()
            .solve(
                verbose=False,
                linear_solver="dense_cholesky",
                trust_region=jaxls.TrustRegionConfig(lambda_initial=1.0),
            )
        )
        return solved[joints]

    places = jax.jit(lambda q: robot.forward_kinematics(q)[..., end, 4:])
    compiled = jax.jit(jax.vmap(solve) if together else solve)

    def call(number: int) -> Any:
        return compiled(wanted if together else wanted[number]).block_until_ready()

    def miss(number: int, found: Any) -> float:
        aims = wanted if together else wanted[number]
        return float(np.linalg.norm(np.asarray(places(found)) - aims, axis=-1).max())

    return Calls(count=1 if together else len(wanted), call=call, miss=miss)


def _robot(offsets: Any) -> str:
    """The chain as URDF, joints free within a quarter turn either way."""
    links, joints, above = ['<link name="base"/>'], [], "base"
    limit = '<limit lower="-1.5708" upper="1.5708" effort="1" velocity="1"/>'
    nothing = [0.0, 0.0, 0.0]
    for number, offset in enumerate(offsets):
        last = number == len(offsets) - 1
        for k, axis in enumerate(AXES[:1] if last else AXES):
            name = "end" if last else f"bone{number}_{k}"
            place = " ".join(f"{x:.9f}" for x in (nothing if k else offset))
            kind, more = ("fixed", "") if last else ("revolute", f'<axis xyz="{axis}"/>{limit}')
            links.append(f'<link name="{name}"/>')
            joints.append(
                f'<joint name="to_{name}" type="{kind}"><parent link="{above}"/>'
                f'<child link="{name}"/><origin xyz="{place}"/>{more}</joint>'
            )
            above = name
    return f'<robot name="arm">{"".join(links)}{"".join(joints)}</robot>'
