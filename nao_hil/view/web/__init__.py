"""The page's own parts: HTML, scripts, and their assembly."""
