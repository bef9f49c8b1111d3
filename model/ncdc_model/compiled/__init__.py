"""The golden model's integers by compiled C functions: the same bits, a hundred times faster."""
