"""Runs of a built simulation, as they were: what each was given, and all that it gave."""

import hashlib
from dataclasses import dataclass

__all__ = ["Transcript"]

# Lines that begin so are for a progress bar, or the simulator's own.
_NO_RESULT = "PROGRESS ", "- "
_MAX_LINES = 1000      # that a report holds


@dataclass(frozen=True)
class Transcript:
    """One run of a simulation.

    Parameters
    ----------
    command : tuple of str
        The program with its plusargs.
    files : dict
        Content of each file that it reads, by name.
    lines : tuple of str
        What it printed.
    written : dict
        Content of each file that it wrote, by name.
    """
    command: tuple
    files: dict
    lines: tuple
    written: dict

    @property
    def report(self):
        """What the run measured: its lines of results, many of them as their number and a hash, and
        a hash of each file."""
        lines = [line for line in self.lines if not line.startswith(_NO_RESULT)]
        if len(lines) > _MAX_LINES:
            lines = [f"{len(lines)} lines",
                     hashlib.sha256("\n".join(lines).encode()).hexdigest()]
        return {"lines": lines,
                "written": {name: hashlib.sha256(content).hexdigest()
                            for name, content in sorted(self.written.items())}}
