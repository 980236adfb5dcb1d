"""`python -m lab.cli`: the command line without the installed script."""

from lab.cli.main import main

main()
