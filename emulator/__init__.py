"""The robot that isn't there: PyBullet physics under an emulated NAO DCM."""
