"""Heavy requests: weighed, and answered by confined worker processes, a bounded number at once."""
