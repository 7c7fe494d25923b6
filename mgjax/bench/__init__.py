"""Benchmarks of the library, timed by turns."""
