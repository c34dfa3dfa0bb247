"""The command line and the experiments: where everything is wired together."""
