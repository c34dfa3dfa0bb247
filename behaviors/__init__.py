"""The built-in behaviors, one file each."""
