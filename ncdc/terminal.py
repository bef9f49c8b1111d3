"""What long work shows on the terminal."""

import sys

__all__ = ["Progress", "Steps", "percent"]


class Progress:
    """Tells on stderr how far a long step is: one line kept up to date on a terminal, elsewhere a
    line per quarter."""

    def __init__(self, name):
        self.name, self.shown = name, None
        self.step, self.end = (1, "") if sys.stderr.isatty() else (25, "\n")

    def __call__(self, fraction, note=""):
        percent = int(100 * fraction) // self.step * self.step
        if percent != self.shown:
            self.shown = percent
            start = "" if self.end else "\r"
            print(f"{start}{self.name}: {percent:3d} %{note}   ", file=sys.stderr, flush=True,
                  end="\n" if fraction >= 1 else self.end)


class Steps:
    """Tells on stderr which step of the work called ``name`` is running: one line kept up to date
    on a terminal, elsewhere a line each, or nothing if ``quiet``."""

    def __init__(self, name, quiet=False):
        self.name, self.quiet = name, quiet

    def __call__(self, step):
        if sys.stderr.isatty():
            end = "\n" if step == "done" else ""
            print(f"\r{self.name}: {step}\x1b[K", end=end, file=sys.stderr, flush=True)
        elif not self.quiet:
            print(f"{self.name}: {step}", file=sys.stderr, flush=True)


def percent(progress):
    """``progress(fraction)`` as a callback of (done, total)."""
    return lambda done, total: progress(done / total)
