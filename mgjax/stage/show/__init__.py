"""What is to be seen, as plain records that the page draws."""
