"""GLB files (glTF 2.0 in one binary file): animated skeletons with a body, in and out.

Reading needs no further package; writing needs pygltflib (the extra ``export``).
"""
