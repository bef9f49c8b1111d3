"""The number of threads of the linear algebra libraries."""

from contextlib import ContextDecorator

from threadpoolctl import threadpool_limits

__all__ = ["one_thread"]


class one_thread(ContextDecorator):
    """NumPy's and SciPy's BLAS use one thread in the block or the decorated function.

    The matrices here are small: several threads wait longer than they compute and take ten times
    the processor time. They also split sums differently.
    """

    def _recreate_cm(self):
        return one_thread()

    def __enter__(self):
        self._limits = threadpool_limits(1, user_api="blas")
        return self

    def __exit__(self, *_):
        self._limits.restore_original_limits()
