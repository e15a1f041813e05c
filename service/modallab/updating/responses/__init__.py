"""Updating on measured frequency responses, without modes between."""
