"""What players can do: clips of hits and links, their transitions and matching (§3, eqs 1–2)."""
