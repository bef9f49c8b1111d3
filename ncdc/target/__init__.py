"""Pages of calibration targets to be printed."""
