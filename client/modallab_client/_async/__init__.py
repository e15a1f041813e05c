"""The client, a file a resource; written with `await`, and made from that without by `unasync.py`."""
