"""The observer study of §6.1: trials, picks, agreement, and energies fitted to what people pick."""
