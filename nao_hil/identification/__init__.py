"""The emulated robot beside a recorded one: replay of commands, comparison, identification of the drives."""
