"""Pictures of what was found: throws, coverage, walks and scenes."""
