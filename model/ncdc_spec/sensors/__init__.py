"""Image sensors as data: registers, set-ups, limits, timing."""
