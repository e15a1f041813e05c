"""Migrations of the tables, packaged with the service."""
