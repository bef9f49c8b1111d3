"""What the C library does with freed memory."""

import ctypes

__all__ = ["keep_freed_memory"]

# Parameters of glibc's mallopt.
_TRIM_THRESHOLD, _MMAP_MAX = -1, -4
_NEVER = 2**31 - 1


def keep_freed_memory():
    """Have the process keep freed memory for its next arrays, where the C library is glibc.

    Else each large picture is new memory of the system, which it clears: that takes a tenth of the
    time of a calibration.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_MMAP_MAX, 0)
        mallopt(_TRIM_THRESHOLD, _NEVER)
