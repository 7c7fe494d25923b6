"""Throw: balls at a character that gets out of their way while it plays on (paper A, §6)."""
