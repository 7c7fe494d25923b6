"""What mkdocs needs to make the site: its hooks, players, links and pages of the reference."""
