"""Where the joints of a body model are, from the arrays of its file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from mgjax.core.errors import FileFormatError
from mgjax.io.amass.hierarchy import PARENTS
from mgjax.io.npz.arrays import array_names, numbers, read_arrays

_KIND = "body model as .npz"


def model_joints(path: str | Path, joints: int, betas: np.ndarray | None) -> np.ndarray:
    """Places of the first joints in the rest pose, in the model's coordinates.

    With ``J_regressor`` [N,V] and ``v_template`` [V,3] they are J_regressor · v, where v is the
    template plus, if the model has ``shapedirs`` [V,3,B], the shape that ``betas`` tell (SMPL,
    eqs. 8 and 10); otherwise the array ``J`` [N,3] is taken.

    Args:
        path: of an .npz file with plain arrays.
        joints: how many are needed.
        betas: shape of the person, of which as many as the model knows are used.

    Returns:
        [joints,3], m.

    Raises:
        FileFormatError: arrays are missing, of other shapes, pickled, or of another hierarchy.
    """
    present = array_names(path, _KIND)
    regressed = {"J_regressor", "v_template"} <= present
    wanted = ["J_regressor", "v_template"] if regressed else ["J"]
    if regressed and betas is not None and "shapedirs" in present:
        wanted.append("shapedirs")
    arrays = read_arrays(path, [*wanted, "kintree_table"], _KIND)
    _check_parents(path, arrays, joints)
    if not regressed:
        places = numbers(path, arrays, "J", ("N", 3))
    else:
        regressor = numbers(path, arrays, "J_regressor", ("N", "V"))
        vertices = numbers(path, arrays, "v_template", (regressor.shape[1], 3))
        if betas is not None and "shapedirs" in arrays:
            directions = numbers(path, arrays, "shapedirs", (len(vertices), 3, "B"))
            count = min(directions.shape[2], len(betas))
            vertices = vertices + directions[:, :, :count] @ betas[:count]
        places = regressor @ vertices
    if len(places) < joints:
        raise FileFormatError(path, None, f"{len(places)} joints", f"the {joints} of the motion")
    return places[:joints]


def _check_parents(path: str | Path, arrays: dict[str, np.ndarray], joints: int) -> None:
    """The hierarchy must be SMPL's, as far as the motion goes."""
    table = numbers(path, arrays, "kintree_table", (2, "N"))
    parents = tuple(int(parent) for parent in table[0, 1:joints])
    if parents != PARENTS[1:joints]:
        got = f"parents {', '.join(map(str, parents[:8]))} …"
        expected = f"those of SMPL, {', '.join(map(str, PARENTS[1:9]))} …"
        raise FileFormatError(path, None, got, expected)
