"""Files made by hand or from a seed, small and valid."""

from __future__ import annotations

import numpy as np

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0.0 0.0 0.0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation
  JOINT Chest
  {
    OFFSET 0.0 60.0 0.0
    CHANNELS 3 Zrotation Yrotation Xrotation
    End Site
    {
      OFFSET 0.0 30.0 0.0
    }
  }
  JOINT LeftUpLeg
  {
    OFFSET 10.0 -5.0 0.0
    CHANNELS 3 Zrotation Yrotation Xrotation
    JOINT LeftFoot
    {
      OFFSET 0.0 -75.0 1.0
      CHANNELS 3 Zrotation Yrotation Xrotation
      End Site
      {
        OFFSET 0.0 -5.0 12.0
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.0083333
0.0 90.0 0.0 0.0 0.0 0.0 0.0 0.0 0.0 1.0 2.0 3.0 4.0 5.0 6.0
1.0 91.0 2.0 5.0 10.0 15.0 1.0 2.0 3.0 -1.0 -2.0 -3.0 7.0 8.0 9.0
2.0 92.0 4.0 90.0 45.0 30.0 2.0 4.0 6.0 10.0 20.0 30.0 -4.0 -5.0 -6.0
"""

ASF = """# made by hand
:version 1.10
:name body
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
  a body of five bones
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
     id 1
     name lfemur
     direction 0.34 -0.94 0
     length 7.5
     axis 0 0 20 XYZ
     dof rx ry rz
     limits (-160.0 20.0)
            (-70.0 70.0)
            (-60.0 70.0)
  end
  begin
     id 2
     name ltibia
     direction 0.34 -0.94 0
     length 7.3
     axis 0 0 20 XYZ
     dof rx
     limits (-10.0 170.0)
  end
  begin
     id 3
     name back
     direction 0 1 0
     length 8
     axis 10 20 30 XYZ
     dof rx ry rz
  end
  begin
     id 4
     name head
     direction 0 1 0.1
     length 3
     axis 0 0 0 XYZ
  end
:hierarchy
  begin
    root lfemur back
    lfemur ltibia
    back head
  end
"""

AMC = """#!OML:ASF made by hand
:FULLY-SPECIFIED
:DEGREES
1
root 1 16 2 5 10 15
lfemur 10 20 30
ltibia 40
back 1 2 3
2
root 2 17 3 -5 -10 -15
lfemur -10 -20 -30
ltibia 50
back 4 5 6
3
root 3 18 4 90 80 70
lfemur 60 -60 60
ltibia 100
back -40 50 60
"""

CHANNEL_SETS = {
    0: "",
    1: "Yrotation",
    2: "Zrotation Xrotation",
    3: "Yrotation Xrotation Zrotation",
    6: "Xposition Yposition Zposition Zrotation Xrotation Yrotation",
}


def random_hierarchy(rng: np.random.Generator, joints: int, scale: float) -> list[dict]:
    """Joints depth first, about a body in size: name, parent, offset, channels, is_end."""
    rows = [{"name": "j0", "parent": -1, "offset": np.zeros(3), "channels": CHANNEL_SETS[6]}]
    for j in range(1, joints):
        sets = list(CHANNEL_SETS.values())
        rows.append(
            {
                "name": f"j{j}",
                "parent": int(rng.integers(max(0, j - 3), j)),
                "offset": rng.uniform(-0.4, 0.4, 3) * scale,
                "channels": sets[int(rng.integers(len(sets)))],
            }
        )
    return rows


def bvh_text(rows: list[dict], values: np.ndarray, frame_time: str = "0.0083333") -> str:
    """BVH of a hierarchy; ``values`` are in the order of the joints in the file."""
    children: dict[int, list[int]] = {}
    for j, row in enumerate(rows):
        children.setdefault(row["parent"], []).append(j)
    lines = ["HIERARCHY"]

    def write(j: int) -> None:
        row = rows[j]
        lines.append(f"{'ROOT' if j == 0 else 'JOINT'} {row['name']}")
        lines.append("{")
        lines.append("OFFSET " + " ".join(repr(float(v)) for v in row["offset"]))
        lines.append(f"CHANNELS {len(row['channels'].split())} {row['channels']}")
        for child in children.get(j, []):
            write(child)
        if j not in children:
            lines.extend(["End Site", "{", "OFFSET 0 1 0", "}"])
        lines.append("}")

    write(0)
    lines += ["MOTION", f"Frames: {len(values)}", f"Frame Time: {frame_time}"]
    lines += [" ".join(repr(float(v)) for v in row) for row in values]
    return "\n".join(lines) + "\n"


def depth_first(rows: list[dict]) -> list[int]:
    """The order in which :func:`bvh_text` writes the joints."""
    order: list[int] = []
    stack = [0]
    while stack:
        order.append(stack.pop())
        stack += [j for j, row in enumerate(rows) if row["parent"] == order[-1]][::-1]
    return order
