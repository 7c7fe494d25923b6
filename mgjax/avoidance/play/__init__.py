"""A character that plays on while attacks come and answers are searched for (§6)."""
