"""Motion put on another skeleton: other names, proportions, rest pose and bone axes."""
