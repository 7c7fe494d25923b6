"""How the offset between two windows dies away in a transition.

A transition plays the second window plus an offset. In its first frame the offset is all of the
difference of the two windows, in its last it is none. Each form is a linear map from the
differences in all frames to the offsets in all frames, so that root, joints and places share it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from mgjax.core.errors import ConfigError
from mgjax.core.timing.easing import smoothstep
from mgjax.graph.config import BLENDS


@dataclass(frozen=True, kw_only=True, eq=False)
class BlendForm:
    """One way to blend.

    Attributes:
        decay: maps differences to offsets. [W+1, W+1]
        support: whether the windows are aligned, and the root is led, by the feet that stand in
            both.
        continuous: whether a joint keeps to the arc on which it began to turn; without, it takes
            the shorter one in each frame.
    """

    decay: Float[np.ndarray, "W1 W1"]
    support: bool
    continuous: bool


def blend_weights(window: int) -> Float[np.ndarray, " W"]:
    """α(p) = 2((p+1)/L)³ − 3((p+1)/L)² + 1 for p = 0 … L−1 (hybrid paper eq. 5): the first clip's
    share."""
    return (1 - np.asarray(smoothstep((np.arange(window) + 1) / window))).astype(np.float32)


def smooth_weights(window: int) -> Float[np.ndarray, " W1"]:
    """1 − 10u³ + 15u⁴ − 6u⁵ at u = p/W, p = 0 … W: neither velocity nor acceleration jumps."""
    u = np.arange(window + 1) / window
    return 1 - u**3 * (10 - 15 * u + 6 * u * u)


def inertia(window: int) -> Float[np.ndarray, "W1 W1"]:
    """Inertialisation (Bollo 2018): the offset goes on from where and how fast it is at frame 0.

    A quintic with value d₀, velocity d₁ − d₀ and no acceleration at u = 0, all 0 at u = 1; the
    differences of later frames do not count.
    """
    decay = np.zeros((window + 1, window + 1))
    u = np.arange(window + 1) / window
    velocity = window * (u - 6 * u**3 + 8 * u**4 - 3 * u**5)
    decay[:, 0] = smooth_weights(window) - velocity
    decay[:, 1] = velocity
    return decay


def blend_form(name: str, window: int) -> BlendForm:
    """The form of that name (``GraphConfig.blend``) for windows of ``window`` frames.

    Raises:
        ConfigError: no form has this name.
    """
    if name == "paper":
        decay = np.diag(np.append(blend_weights(window), 0.0))
    elif name in ("smooth", "smooth+support"):
        decay = np.diag(smooth_weights(window))
    elif name == "support":
        decay = np.diag(1 - np.asarray(smoothstep(np.arange(window + 1) / window)))
    elif name in ("inertial", "inertial+support"):
        decay = inertia(window)
    else:
        raise ConfigError(got=f"blend = {name!r}", expected=" or ".join(BLENDS))
    return BlendForm(
        decay=decay.astype(np.float32),
        support=name.endswith("support"),
        continuous=name != "paper",
    )
