"""The grid index (§5.1): which candidates an attack may need, looked up by the cells it touches."""
