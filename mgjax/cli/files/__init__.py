"""Commands on motion files, and how they read them."""
