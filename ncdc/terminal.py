"""Progress of long work on the terminal."""

import sys

__all__ = ["Progress", "Steps", "end_line", "percent", "say"]


_QUARTER = 25           # per cent between two figures of progress in a log
_open = None            # the stream whose last line is progress that goes on


def say(sentence):
    """Print a ``sentence`` on stderr, in a line of its own even in the middle of progress."""
    end_line()
    print(sentence, file=sys.stderr, flush=True)


def end_line():
    """End the line of progress on stderr, if it is not ended."""
    global _open
    if _open is sys.stderr and _open is not None:
        print(file=sys.stderr, flush=True)
    _open = None


class Progress:
    """Prints the progress of a long step on stderr, in one line.

    A terminal's line is rewritten; a log gets a figure for each quarter, as it grows.
    """

    def __init__(self, name):
        self.name, self.shown = name, None
        self.terminal = sys.stderr.isatty()

    def __call__(self, fraction, note=""):
        """``fraction`` from 0 to 1; the ``note`` is shown on terminals, and at the end."""
        global _open
        step = 1 if self.terminal else _QUARTER
        percent = int(100 * fraction) // step * step
        if percent == self.shown:
            return
        if self.terminal:
            text = f"\r{self.name}: {percent:3d} %{note}   "
        else:
            # A sentence in between has ended the line.
            start = "" if self.shown is not None and _open is sys.stderr else f"{self.name}:"
            text = f"{start} {percent} %" + (note if fraction >= 1 else "")
        self.shown = percent
        print(text, file=sys.stderr, flush=True, end="\n" if fraction >= 1 else "")
        _open = None if fraction >= 1 else sys.stderr


class Steps:
    """Prints on stderr which step of the work called ``name`` is running.

    A terminal's line is rewritten; elsewhere each step has a line, or none if ``quiet``.
    """

    def __init__(self, name, quiet=False):
        self.name, self.quiet = name, quiet

    def __call__(self, step):
        global _open
        if sys.stderr.isatty():
            done = step == "done"
            print(f"\r{self.name}: {step}\x1b[K", end="\n" if done else "", file=sys.stderr,
                  flush=True)
            _open = None if done else sys.stderr
        elif not self.quiet:
            print(f"{self.name}: {step}", file=sys.stderr, flush=True)


def percent(progress):
    """``progress(fraction)`` as a callback of (done, total)."""
    return lambda done, total: progress(done / total)
