"""Running things: configurations, timings, pictures."""
