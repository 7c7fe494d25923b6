"""The scripts of the procedural set: what happens in each clip."""

from __future__ import annotations

SCRIPTS = {
    "stance": "idle 2; look; idle 1.6; look; idle 1.6",
    "steps": "idle; step forward; idle; step back; idle; step left; idle; step right; idle",
    "turns": "idle; turn 45; idle; turn -45; idle; turn 90; idle; turn -90; duck; idle",
    "walk": "idle; walk 4.2; idle; turn 90; idle 0.8; walk 3; sway left; idle",
    "walk_curve": "idle; walk 4.2 70; idle; walk 3.6 -60; idle",
    "walk_on": "idle; walk_on 3.6 duck; idle; walk_on 3 sway right; idle; walk_on 3 duck left;"
    " idle",
    "duck": "idle; duck; idle; duck left; idle; duck right; idle; duck; step back; duck; idle",
    "sway": "idle; sway left; idle; sway right; idle; sway right; step left; sway left; idle",
    "lean_twist": "idle; lean_back; idle; twist left; idle; twist right; idle; lean_back; idle;"
    " twist left; idle; twist right; idle",
    "sidestep": "idle; sidestep left; idle; sidestep right; idle; sidestep right; idle;"
    " sidestep left; idle; sidestep left; idle; sidestep right; idle",
    "crouch_jump": "idle; crouch; idle; jump; idle; crouch; idle; jump; idle",
    "hop": "idle; jump left; idle; jump right; idle; jump forward; idle; jump back; idle;"
    " crouch; idle",
    "backstep": "idle; backstep; idle; dash; idle; crouch; idle; dash; idle; backstep; idle",
    "sidle": "idle; sidle left; idle; crouch; idle; sidle right; idle; duck; idle; crouch; idle",
    "mixed1": "idle; step back; duck; idle; turn 45; sway right; idle; walk 2.4; jump; idle",
    "mixed2": "idle; walk 2.4; sidestep left; idle; step right; twist left; turn -45; crouch; idle",
    "mixed3": "idle; step forward; lean_back; idle; walk 3 45; twist right; idle; dash; idle",
}
"""Of each clip, the verbs of :data:`mgjax.clips.procedural.verbs.VERBS` with their arguments."""
