"""When a walk is where: the time scale of edges (§4.1, eqs 2–3) and a smooth time warp."""
