"""Reproducible experiments: one script for each table, figure or claim."""

import os

# Set before jax is imported: see mgjax.core.xla.compilation.
os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")
