"""The robot that isn't there: physics under an emulated NAO DCM."""
