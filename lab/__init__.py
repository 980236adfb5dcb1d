"""What needs both sides: the command line, runs, experiments, figures and benchmarks."""
