"""Interaction with people: speech, sound, dialogues, photos, faces, lights."""
