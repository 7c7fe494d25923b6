"""A live player: kicks recognised while they happen decide the passes of a scene."""
