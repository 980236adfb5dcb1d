"""The states of the controller: approach, walk, stand, fallen, motion, rest."""
