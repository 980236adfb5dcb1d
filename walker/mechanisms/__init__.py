"""The mechanisms of the walk, one page for each behaviour, with its inputs and outputs."""
