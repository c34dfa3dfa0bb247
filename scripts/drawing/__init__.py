"""Pictures of maps and worlds."""
