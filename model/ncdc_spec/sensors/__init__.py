"""Image sensors as data: registers, initialisation, limits, timing."""
