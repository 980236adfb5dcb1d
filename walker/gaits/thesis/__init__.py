"""The gaits of Prenner's thesis: statically and dynamically stable."""
