"""Each peer's half of a comparison: numpy and the peer, which is imported where it is used."""
