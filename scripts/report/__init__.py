"""A run or a map as one page: read into plain data, packed, put into a page, or sent while it happens."""
