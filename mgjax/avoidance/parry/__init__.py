"""Attacks that nothing avoids, met by a forearm or a hand: a smooth offset of one arm."""
