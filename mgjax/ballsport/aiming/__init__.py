"""Aimed passes (§4, eqs 7–8): the launch whose flight ends where it should."""
