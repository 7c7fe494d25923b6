"""Motions as named NumPy arrays in one .npz file, for programs that know nothing of skeletons.

| key | shape, type | what |
|---|---|---|
| ``version`` | int | of this table: 1 |
| ``names`` | [J] text | joints, unique |
| ``parents`` | [J] int | index of each joint's parent, −1 for the root; a parent comes first |
| ``offsets`` | [J,3] float32 | each joint's place in its parent's frame, m; in the rest pose all |
| | | rotations are the identity |
| ``end_joints`` | [K] int | joints that only mark the end of a bone |
| ``quaternions`` | [F,J,4] float32 | local rotations, wxyz, unit; the root's in the world |
| ``root`` | [F,3] float32 | place of the root in the world, m; y up |
| ``fps`` | float64 | frames per second |
| ``joint_offsets`` | [F,J,3] float32 | only where bones are not rigid, instead of ``offsets`` |

``numpy.load(file, allow_pickle=False)`` reads it.
"""

VERSION = 1
KEYS = ("version", "names", "parents", "offsets", "end_joints", "quaternions", "root", "fps")
"""Those that every file has; ``joint_offsets`` is there only if it is needed."""
