"""From an attack to the walk that avoids it: search, verification and the selection."""
