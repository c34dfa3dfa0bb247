"""Campaigns that torment the readers of map and world files, and the writer of maps. POSIX only."""
