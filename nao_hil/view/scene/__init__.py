"""What the page draws in 3-D."""
