"""Campaigns that stress the readers of map and world files, and the writer of maps. POSIX only."""
