"""USD files with an animated UsdSkel skeleton: writing. Needs usd-core (the extra ``usd``)."""
