"""The ball's flight (§4, eqs 3–6): gravity, air resistance and bounces."""
