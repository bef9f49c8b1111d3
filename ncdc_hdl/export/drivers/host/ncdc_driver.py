"""Driver of the NCDC corrector in Python; it needs only the files generated with it."""

import ncdc_registers as registers
from ncdc_white_balance import LARGEST_GAIN, grey_world

__all__ = ["Corrector", "CorrectorError", "grey_world"]

_COLOURS = ("RED", "GREEN", "BLUE")
_LARGEST_NODE = 256     # largest node of a tone curve
_LARGEST_NUMBER = (1 << 26) - 1     # of a table of matrices
_LARGEST_PITCH = (1 << 16) - 1      # of a list of views


class CorrectorError(RuntimeError):
    """The corrector does not answer, rejected a write or a frame, or was not ready in time."""


def _field(word, mask):
    """The bits of ``word`` under ``mask``, a run of ones, as a number."""
    return (word & mask) // (mask & -mask)


class Corrector:
    """One corrector, reached through two functions.

    Parameters
    ----------
    read : callable
        ``read(offset)`` returns the 32-bit word at a byte offset.
    write : callable
        ``write(offset, value)``.

    Raises
    ------
    CorrectorError
        If no corrector answers, or its registers are not supported.

    Attributes
    ----------
    lanes, word : int
        Pixels per clock; bytes of a memory word.
    stream : bool
        Pixels leave as a video stream.
    colour : bool
        It has gains after interpolation, a tone curve, and sums of the colours.
    raw_gains : bool
        It has gains before interpolation, of raw frames as they are read.
    fixed_lens : bool
        Its lens, sizes, format and strips are constants.
    has_view : bool
        It has registers for the matrix of a view.
    interpolations : tuple of str
        Names of the interpolations that it has, such as "fast".
    largest : (int, int)
        Width and height of the largest corrected image.
    """

    def __init__(self, read, write):
        self.read, self.write = read, write
        word = self.get("ID")
        if word != registers.ID_VALUE:
            raise CorrectorError(f"ID reads {word:#010x}, {registers.ID_VALUE:#010x} is needed")
        word = self.get("CAPABILITIES")
        self.version, self.lanes, self.word = (
            _field(word, mask) for mask in (registers.CAPABILITIES_VERSION,
                                            registers.CAPABILITIES_LANES,
                                            registers.CAPABILITIES_WORD))
        self.stream = bool(word & registers.CAPABILITIES_STREAM)
        self.colour = bool(word & registers.CAPABILITIES_COLOUR)
        self.raw_gains = bool(word & registers.CAPABILITIES_RAW_GAINS)
        self.fixed_lens = bool(word & registers.CAPABILITIES_FIXED_LENS)
        self.has_view = bool(word & registers.CAPABILITIES_VIEW)
        self.interpolations = tuple(name for name, mask in registers.INTERPOLATIONS.items()
                                    if word & mask)
        word = self.get("LARGEST")
        self.largest = tuple(_field(word, mask) for mask in (registers.LARGEST_WIDTH,
                                                             registers.LARGEST_HEIGHT))
        if self.version != registers.VERSION:
            raise CorrectorError(f"the corrector's registers are of version {self.version}, this "
                                 f"driver is for {registers.VERSION}")

    def get(self, name):
        """Value of the register ``name``, as read."""
        return self.read(registers.OFFSET[name])

    def put(self, name, value):
        """Write the register ``name``; negative values in two's complement."""
        self.write(registers.OFFSET[name], value & 0xFFFFFFFF)

    def load(self, lens):
        """Write ``lens``, a dict of ncdc_lenses.py, to the set that the next commit makes active.

        Its valid rows go to the bank that is not in use; a frame that runs meanwhile does not
        use them. The lens comes with one view, its own picture: load it first, then write
        views and matrices. A corrector with a fixed lens accepts that one alone, and nothing is
        written.

        Raises
        ------
        CorrectorError
            If the corrector has another, fixed lens, a commit still waits, the number of neurons
            differs, the corrector lacks the lens's interpolation, the corrected image is larger
            than the corrector's or no multiple of its lanes, or a write was rejected.
        """
        if self.fixed_lens:
            found, digest = f"{self.get('DIGEST'):08x}", lens["digest"][:8]
            if found != digest:
                raise CorrectorError(f"the lens has the digest {digest}, the corrector has the "
                                     f"fixed lens {found}")
            return
        status, neurons = self.get("STATUS"), self.get("NEURONS")
        if neurons != lens["neurons"]:
            raise CorrectorError(f"the lens has {lens['neurons']} hidden neurons, "
                                 f"the corrector {neurons}")
        if lens["interpolation"] not in self.interpolations:
            raise CorrectorError(f"the lens is for the interpolation {lens['interpolation']}, the "
                                 f"corrector has {', '.join(self.interpolations)}")
        if (lens["width"] > self.largest[0] or lens["height"] > self.largest[1]
                or lens["width"] % self.lanes):
            raise CorrectorError(
                f"the lens makes {lens['width']}x{lens['height']} pixels, the corrector up to "
                f"{self.largest[0]}x{self.largest[1]} in rows that are a multiple of {self.lanes}")
        self._free(status)
        bank = 0 if status & registers.STATUS_BANK else 1
        for name, value in lens["values"].items():
            self.put(name, value)
        self.put("VALID_WINDOW", bank)
        for k, span in enumerate(lens["valid_rows"]):
            self.write(registers.VALID_ROWS + 4 * k, span)
        self.put("VALID_BANK", bank)
        self._taken()

    def altered(self):
        """Whether another lens than that of DIGEST may be loaded; a reset keeps valid rows."""
        return bool(self.get("ALTERED"))

    def place(self, lens, source, target=None):
        """Memory of the raw and of the corrected frame of ``lens``, also for the next commit.

        Each is (byte address, bytes). Nothing outside is read or written, for any values of the
        registers. A corrector with a video stream needs no ``target``.

        Raises
        ------
        CorrectorError
            If a buffer does not begin on a memory word, or is too small, or a commit still waits.
        """
        buffers = [("SOURCE", source, lens["source_bytes"])]
        buffers += [] if self.stream else [("TARGET", target, lens["target_bytes"])]
        for name, (address, size), needed in buffers:
            if address % self.word or not 0 <= address < address + size < 1 << 32:
                raise CorrectorError(f"the {name.lower()} is at {address:#x}, a multiple of "
                                     f"{self.word} below 4 GB is needed")
            if size < needed:
                raise CorrectorError(f"the {name.lower()} has {size} bytes, the lens needs "
                                     f"{needed}")
        self._free(self.get("STATUS"))
        for name, (address, size), _ in buffers:
            self.put(f"{name}_BASE", address)
            self.put(f"{name}_LIMIT", address + size)
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
        """End the frame that runs, soon; :meth:`wait` returns when its last word is in memory."""
        self.put("CTRL", registers.CTRL_ABORT)

    def enable_interrupt(self, enable=True):
        """Enable or disable ``irq`` at the end of a frame."""
        self.put("IRQ_ENABLE", int(enable))

    def faults(self):
        """Names of the faults since the last call, which clears them."""
        bits = self.get("FAULT")
        self.put("FAULT", bits)
        return [name for name in ("SOURCE", "TARGET", "ALIGNMENT", "SIZE", "FORMAT", "MEMORY")
                if bits & getattr(registers, f"FAULT_{name}")]

    def wait(self, polls=None, idle=lambda: None):
        """Wait until a frame is complete and clear DONE; read STATUS at most ``polls`` times.

        ``idle`` is called after each poll without a frame; it may sleep, wait for the
        interrupt, or raise.

        Raises
        ------
        CorrectorError
            If no frame is complete by then, or the frame lacks pixels, or has a fault.
        """
        left, status = polls, self.get("STATUS")
        while not status & registers.STATUS_DONE:
            if polls is not None:
                left -= 1
                if left <= 0:
                    raise CorrectorError(f"no frame is complete after {polls} polls")
            idle()
            status = self.get("STATUS")
        self.put("STATUS", registers.STATUS_DONE)
        if status & registers.STATUS_FAULT:
            raise CorrectorError(f"the corrector rejected: {', '.join(self.faults())}")
        if status & registers.STATUS_ABORTED:
            raise CorrectorError("the frame was aborted")

    def counters(self):
        """Counters of the last complete frame, by name."""
        return {name: self.get(name) for name in registers.COUNTERS}

    def colour_sums(self):
        """Sums of red, green and blue over the last complete frame, before :meth:`white_balance`.

        Gains before interpolation are in them. Only pixels with a source count; their number is
        the counter VALID_PIXELS.
        """
        self._has_colour()
        return tuple(self.get(f"{name}_SUM") for name in _COLOURS)

    def white_balance(self, gains):
        """Gains of red, green and blue after interpolation in 256ths, as from ``grey_world``, for
        the next commit.

        Raises
        ------
        CorrectorError
            If there are not three, one is no integer of 0 to 1023, a commit still waits, or the
            corrector has no colour.
        """
        self._has_colour()
        self._put_set([f"GAIN_{name}" for name in _COLOURS], gains, "gain", LARGEST_GAIN)

    def raw_balance(self, gains):
        """Gains of red, green and blue samples before interpolation, for the next commit.

        In 256ths, as from ``grey_world`` with the sums and the gains of the last frame. Raises
        :class:`CorrectorError` as :meth:`white_balance`, or if the corrector has no such gains.
        """
        if not self.raw_gains or "RAW_GAIN_RED" not in registers.OFFSET:
            raise CorrectorError("the corrector has no gains before interpolation: it was "
                                 "generated without --raw-gains")
        self._put_set([f"RAW_GAIN_{name}" for name in _COLOURS], gains, "gain", LARGEST_GAIN)

    def view(self, words):
        """The matrix of a view, nine register values row by row, for the next commit.

        Raises
        ------
        CorrectorError
            If there are not nine, one does not fit 32 bits, a commit still waits, or the corrector
            has no view.
        """
        names = [name for name in registers.OFFSET
                 if name.startswith("VIEW_") and not name.startswith("VIEW_ROWS")]
        if not self.has_view or not names:
            raise CorrectorError("the corrector has no view: it was generated without --view")
        self._put_set(names, words, "number of the view's matrix", (1 << 31) - 1, -1 << 31)

    def views(self, entries):
        """Views that each start makes of one raw frame, from the next commit on.

        Parameters
        ----------
        entries : sequence of dict
            Value of each word of an entry: "X_U" to "Z_0" of the matrix, "WIDTH", "HEIGHT",
            "OFFSET", "PITCH", "FORMAT", "STRIP", "SPLIT". What is absent keeps its value.

        Raises
        ------
        CorrectorError
            If there are none or too many, a word is unknown, a pitch is beyond 16 bits, a commit
            still waits, or the corrector has no list of views.
        """
        if "VIEWS" not in registers.OFFSET:
            raise CorrectorError("the corrector has no list of views: it was generated without "
                                 "--views")
        most = _field(self.get("VIEWS_STATE"), registers.VIEWS_STATE_MAX)
        if not 1 <= len(entries) <= most:
            raise CorrectorError(f"there are {len(entries)} views, the limits are 1 and {most}")
        values = {f"VIEW{k}_{word}": value for k, entry in enumerate(entries)
                  for word, value in entry.items()}
        for name, value in values.items():
            if name not in registers.OFFSET:
                raise CorrectorError(f"{name} is no register of the list of views")
            if name.endswith("_PITCH") and not 0 <= value <= _LARGEST_PITCH:
                raise CorrectorError(f"{name} is {value}, the limits are 0 and {_LARGEST_PITCH}")
        self._free(self.get("STATUS"))
        for name, value in (values | {"VIEWS": len(entries)}).items():
            self.put(name, value)
        self._taken()

    def view_rows(self, step, matrices):
        """A table of matrices down the raw frame, for the next commit; none switches it off.

        Each has nine numbers row by row, see docs/explanation/view.md of the project. That of the
        raw row k ``step`` is the one of number k. A frame that runs meanwhile does not use them.

        Raises
        ------
        CorrectorError
            If there is no such step, there are more matrices than the corrector has space for, one
            has not nine numbers or one that does not fit 27 bits, a commit still waits, or the
            corrector has no table.
        """
        if "VIEW_ROWS" not in registers.OFFSET:
            raise CorrectorError("the corrector has no table of matrices: it was generated without "
                                 "--view-rows")
        self._free(self.get("STATUS"))      # a commit that waits could still change the bank
        status = self.get("VIEW_ROWS_STATUS")
        limit = _field(status, registers.VIEW_ROWS_STATUS_LIMIT)
        if step not in registers.VIEW_ROW_STEPS:
            raise CorrectorError(f"the step is {step} rows, one of "
                                 f"{', '.join(map(str, registers.VIEW_ROW_STEPS))} is needed")
        if len(matrices) > limit:
            raise CorrectorError(f"there are {len(matrices)} matrices, the limit is {limit}")
        for k, matrix in enumerate(matrices):
            if len(matrix) != 9 or any(number not in range(-_LARGEST_NUMBER - 1,
                                                           _LARGEST_NUMBER + 1)
                                       for number in matrix):
                raise CorrectorError(f"matrix {k} is {list(matrix)}, nine integers of "
                                     f"{-_LARGEST_NUMBER - 1} to {_LARGEST_NUMBER} are needed")
        bank = 0 if status & registers.VIEW_ROWS_STATUS_BANK else 1
        for k, matrix in enumerate(matrices):
            for number, value in enumerate(matrix):
                row, column = divmod(number, 3)
                self.write(registers.VIEW_MATRICES + 4096 * bank + 64 * k + 16 * row + 4 * column,
                           int(value) & 0xFFFFFFFF)
        self.put("VIEW_ROWS", len(matrices))
        self.put("VIEW_ROWS_STEP", registers.VIEW_ROW_STEPS.index(step))
        self.put("VIEW_ROWS_BANK", bank)
        self._taken()

    def tone(self, nodes):
        """Nodes of the tone curve, as in TONES of ncdc_registers.py, for the next commit.

        Raises
        ------
        CorrectorError
            If there are not 17, one is no integer of 0 to 256, a commit still waits, or the
            corrector has no colour.
        """
        self._has_colour()
        names = [name for name in registers.OFFSET if name.startswith("TONE")]
        self._put_set(names, nodes, "node of the tone curve", _LARGEST_NODE)

    def _put_set(self, names, values, what, largest, smallest=0):
        if len(values) != len(names):
            raise CorrectorError(f"there are {len(values)} values, {len(names)} are needed, each a "
                                 f"{what}")
        for value in values:
            if value not in range(smallest, largest + 1):
                raise CorrectorError(f"a {what} is {value}, an integer of {smallest} to {largest} "
                                     f"is needed")
        self._free(self.get("STATUS"))
        for name, value in zip(names, values):
            self.put(name, int(value))
        self._taken()

    def _has_colour(self):
        if not self.colour or "GAIN_RED" not in registers.OFFSET:
            raise CorrectorError("the corrector has no registers for colour: it was generated "
                                 "without --colour")

    def _free(self, status):
        if status & registers.STATUS_COMMITTED:
            raise CorrectorError("a commit waits for its frame boundary: nothing was written")

    def _taken(self):
        if self.get("STATUS") & registers.STATUS_REFUSED:
            self.put("STATUS", registers.STATUS_REFUSED)
            raise CorrectorError("the corrector rejected a write")
