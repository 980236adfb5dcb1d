"""The page's own parts: HTML, scripts, and what puts them together."""
