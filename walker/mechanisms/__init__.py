"""The mechanisms of the walk, one page for each behaviour; each says what it reads and gives."""
