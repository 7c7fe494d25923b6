"""The stage: motions, throws, walks and scenes in a browser, in a notebook and in one file."""
