"""Map files: SQLite, crash-safe, versioned, validated."""
