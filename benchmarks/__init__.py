"""What tolman costs, beside what else there is. Not installed: run from the root of the repository."""
