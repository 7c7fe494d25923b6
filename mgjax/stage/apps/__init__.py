"""What runs behind the page: throw, sketch, match and edit."""
