"""What needs both sides: the command line, runs, experiments, figures and benchmarks."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("nao-hil")
except PackageNotFoundError:  # run from a source tree that is not installed
    __version__ = "0+source"
