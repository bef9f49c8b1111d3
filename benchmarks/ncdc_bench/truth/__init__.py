"""Calibration of cameras whose every ray is known: what the report says compared with the truth."""
