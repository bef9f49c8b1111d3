"""Image sensors as data: their register maps."""
