"""The `nao-hil` command: one module per sub-command."""
