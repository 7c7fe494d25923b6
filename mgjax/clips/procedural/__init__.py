"""What the procedural character can do: scores, verbs, avoidance parts, scripts, and life."""
