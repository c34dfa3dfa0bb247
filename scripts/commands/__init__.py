"""The commands of `tolman`, one file each; `tolman.scripts.cli` finds them by name."""
