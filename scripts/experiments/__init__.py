"""`tolman experiment`: what is run, how it is scored, and the report of it."""
