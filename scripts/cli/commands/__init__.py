"""The commands of `tolman`, one file each; `tolman.scripts.cli.program` finds them by name."""
