"""Pictures of the stage for README.md, made anew by ``make pictures``."""
