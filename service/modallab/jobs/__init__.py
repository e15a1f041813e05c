"""Background jobs: tasks, their queue, and worker processes."""
