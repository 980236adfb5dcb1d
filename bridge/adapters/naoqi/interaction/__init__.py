"""What the robot exchanges with people: speech, sound, dialogues, photos, faces, lights."""
