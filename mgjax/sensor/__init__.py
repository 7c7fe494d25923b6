"""Motion sensors: the VMC protocol over OSC, received, assembled into frames, and replayed."""
