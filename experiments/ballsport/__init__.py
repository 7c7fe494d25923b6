"""Experiments of the ball sport room."""
