"""The emulated robot against a recorded one: replay of commands, comparison, identification of the drives."""
