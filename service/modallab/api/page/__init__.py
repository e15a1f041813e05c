"""The page at `/` and the reference of the API at `/docs`."""
