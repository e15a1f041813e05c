"""Store of immutable results: metadata in a database, arrays in files."""
