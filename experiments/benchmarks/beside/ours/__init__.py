"""The work of comparisons, and mgjax's half of each."""
