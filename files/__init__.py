"""Files that nobody trusts: read and written within bounds, with errors that say what is wrong and where."""
