"""What compiled code needs: padding, pytrees, kept results and a persistent cache."""
