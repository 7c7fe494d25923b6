"""Whether a motion really stays clear: exactly, as it is written, or by certain bounds."""
