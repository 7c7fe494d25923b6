"""Folders that commands write, read back as shows: one module for each command."""
