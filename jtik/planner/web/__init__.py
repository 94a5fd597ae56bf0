"""The server of the page, and what it sends."""
