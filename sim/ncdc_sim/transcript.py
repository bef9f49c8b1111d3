"""Runs of a built simulation, as they were: what each was given, and all that it gave."""

import hashlib
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ncdc_sim.runner import run

__all__ = ["Transcript", "transcribed"]

# Lines that begin so are for a progress bar, parts of a hash, or the simulator's own.
_NO_RESULT = "PROGRESS ", "TRACE ", "- "
_MAX_LINES, _MAX_CHARACTERS = 1000, 8_000      # that a report holds


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
    given : str
        What it read from its input.
    """
    command: tuple
    files: dict
    lines: tuple
    written: dict
    given: str = ""

    @property
    def report(self):
        """What the run measured: its lines of results, many of them as their number and a hash, and
        a hash of each file."""
        lines = [line for line in self.lines if not line.startswith(_NO_RESULT)]
        text = "\n".join(lines)
        if len(lines) > _MAX_LINES or len(text) > _MAX_CHARACTERS:
            lines = [f"{len(lines)} lines", hashlib.sha256(text.encode()).hexdigest()]
        return {"lines": lines,
                "written": {name: hashlib.sha256(content).hexdigest()
                            for name, content in sorted(self.written.items())}}


def transcribed(command, hear, transcripts=None, *, files=None, writes=()):
    """Run a built simulation in a folder of its own; contents of the files it wrote, by name.

    Parameters
    ----------
    command : sequence of str
        The program with its plusargs.
    hear : callable
        Called with each line that it prints.
    transcripts : list, optional
        The :class:`Transcript` is added to it, if the run ends well.
    files : dict, optional
        Content of each file that it reads, by name.
    writes : sequence of str
        Names of files that it writes.

    Raises
    ------
    SimulationError
        If it ends with an error status.
    """
    files, lines = files or {}, []

    def on_line(line):
        lines.append(line)
        hear(line)

    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / file).write_bytes(content)
        run(command, folder, on_line)
        written = {file: (folder / file).read_bytes() for file in writes}
    if transcripts is not None:
        transcripts.append(Transcript(tuple(command), files, tuple(lines), written))
    return written
