"""A body around any skeleton, for formats that show one: capsules along the bones, as one mesh."""
