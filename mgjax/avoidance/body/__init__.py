"""The body's volume (§4.2): spheres on bones, sampled for each edge, as compiled code reads it."""
