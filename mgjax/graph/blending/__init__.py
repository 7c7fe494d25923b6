"""How two windows become one transition: alignment on the floor, and what is blended how."""
