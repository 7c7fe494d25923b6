"""Notebooks run at a tiny size in the tests."""

from __future__ import annotations

import os

os.environ["MGJAX_NOTEBOOK_SMOKE"] = "1"  # kernels inherit it
