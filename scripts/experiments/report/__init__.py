"""The Markdown and the pictures of a page of results."""
