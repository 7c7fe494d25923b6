"""Which attacks a graph avoids: thousands of throws, and what they say of it."""
