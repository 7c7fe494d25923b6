"""Small inputs from the field and their right answers, which lie beside the project."""
