"""The energies of a candidate (§4.2, eqs 4–10)."""
