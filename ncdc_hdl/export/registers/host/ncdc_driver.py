"""Driver of the NCDC corrector in Python; needs nothing but ncdc_registers.py beside it."""

import ncdc_registers as registers

__all__ = ["Corrector", "CorrectorError"]


class CorrectorError(RuntimeError):
    """The corrector is not there, refused a write, or was not ready in time."""


class Corrector:
    """One corrector, reached through two functions.

    Parameters
    ----------
    read : callable
        ``read(offset)`` gives the 32-bit word at a byte offset.
    write : callable
        ``write(offset, value)``.

    Raises
    ------
    CorrectorError
        If no corrector answers.
    """

    def __init__(self, read, write):
        self.read, self.write = read, write
        word = self.get("ID")
        if word != registers.ID_VALUE:
            raise CorrectorError(f"ID reads {word:#010x}, {registers.ID_VALUE:#010x} is needed")

    def get(self, name):
        """Value of the register ``name``, as read."""
        return self.read(registers.OFFSET[name])

    def put(self, name, value):
        """Write the register ``name``; negative values in two's complement."""
        self.write(registers.OFFSET[name], value & 0xFFFFFFFF)

    def load(self, lens):
        """Write ``lens``, a dict of ncdc_lenses.py, to the set that the next commit makes active.

        Its valid rows go to the bank that is not in use; a frame that runs meanwhile sees nothing
        of it.

        Raises
        ------
        CorrectorError
            If a commit still waits, the number of neurons differs, or a write was refused.
        """
        status, neurons = self.get("STATUS"), self.get("NEURONS")
        if neurons != lens["neurons"]:
            raise CorrectorError(f"the lens has {lens['neurons']} hidden neurons, "
                                 f"the corrector {neurons}")
        self._free(status)
        bank = 0 if status & registers.STATUS_BANK else 1
        for name, value in lens["values"].items():
            self.put(name, value)
        self.put("VALID_WINDOW", bank)
        for k, span in enumerate(lens["valid_rows"]):
            self.write(registers.VALID_ROWS + 4 * k, span)
        self.put("VALID_BANK", bank)
        self._taken()

    def place(self, source, target):
        """Byte addresses of the raw and the corrected frame, for the next commit as well."""
        self._free(self.get("STATUS"))
        self.put("SOURCE_BASE", source)
        self.put("TARGET_BASE", target)
        self._taken()

    def commit(self):
        """Make what was written active at the next frame boundary."""
        self.put("CTRL", registers.CTRL_COMMIT)

    def start(self):
        """Correct a frame; while one runs, another one may be started."""
        self.put("CTRL", registers.CTRL_START)

    def commit_and_start(self):
        """Both, in one register write."""
        self.put("CTRL", registers.CTRL_COMMIT | registers.CTRL_START)

    def abort(self):
        """End the frame that runs, soon; :meth:`wait` tells when its last word is in memory."""
        self.put("CTRL", registers.CTRL_ABORT)

    def wait(self, polls=None):
        """Wait until a frame is complete and take note of it; read STATUS ``polls`` times at most.

        Raises
        ------
        CorrectorError
            If no frame is complete by then, or the frame lacks pixels.
        """
        left, status = polls, self.get("STATUS")
        while not status & registers.STATUS_DONE:
            if polls is not None:
                left -= 1
                if left <= 0:
                    raise CorrectorError(f"no frame is complete after {polls} polls")
            status = self.get("STATUS")
        self.put("STATUS", registers.STATUS_DONE)
        if status & registers.STATUS_ABORTED:
            raise CorrectorError("the frame was aborted")

    def counters(self):
        """What the last complete frame counted, by name."""
        return {name: self.get(name) for name in registers.COUNTERS}

    def _free(self, status):
        if status & registers.STATUS_COMMITTED:
            raise CorrectorError("a commit waits for its frame boundary: nothing was written")

    def _taken(self):
        if self.get("STATUS") & registers.STATUS_REFUSED:
            self.put("STATUS", registers.STATUS_REFUSED)
            raise CorrectorError("the corrector refused a write")
