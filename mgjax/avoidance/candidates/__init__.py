"""Candidates (eq. 1): walks to an avoidance part that comes at the right time."""
