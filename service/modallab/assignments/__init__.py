"""Sealed assignments: what is hidden for each student, what one may choose, how an answer is marked."""
