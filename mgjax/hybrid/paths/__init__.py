"""Walks along a sketched path: eqs 6–7, a beam, and branch and bound."""
