"""Drawings and pictures of the documentation."""
