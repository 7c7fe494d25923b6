"""Joint places as a table of text: writing."""
