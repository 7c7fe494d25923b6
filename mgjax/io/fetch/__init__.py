"""Motion capture from the network, in files that are whole or not there."""
