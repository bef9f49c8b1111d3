"""What image sensors have in common: what they can do, what is asked of one, what it then does."""

from dataclasses import asdict, dataclass, field
from math import log10

from ncdc_spec.sensors.controls import Controls
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType
from ncdc_spec.sensors.waking import Waking

__all__ = ["Limits", "Link", "Sensor", "Settings", "Setup", "Timing", "UNITY_GAIN",
           "UserRegister", "Write", "bayer_at", "wide"]

UNITY_GAIN = 256        # of ``gain_256``
# MIPI D-PHY: T_HS-EXIT, T_LPX twice, T_HS-PREPARE with T_HS-ZERO and T_HS-TRAIL are 0.5 us in all
# at 400 Mb/s; header and checksum of a row 0.1 us. Sensors take their time.
_ROW_PAUSE_S = 1.5e-6


@dataclass(frozen=True)
class Limits:
    """Ranges of what a user sets, both ends included.

    Parameters
    ----------
    step : int
        Width and height are multiples of it.
    corner_step : int
        So are left and top.
    smallest : (int, int)
        Width and height.
    lines : (int, int)
        Exposure, in lines.
    vertical : (int, int)
        Lines of a frame beyond its height.
    gain_256 : (int, int)
        Gain, 256 is 1.
    pixel_clock_hz : int
        The fastest.
    frame_lines : int
        The most lines of a frame, blanking included; where an exposure makes a frame longer by
        itself, the most that are set.
    reductions : tuple of (int, int)
        Supported pairs (skip, bins) of :class:`Settings`, except the unreduced (1, 1).
    """
    step: int
    corner_step: int
    smallest: tuple
    lines: tuple
    vertical: tuple
    gain_256: tuple
    pixel_clock_hz: int
    frame_lines: int
    reductions: tuple = ()


@dataclass(frozen=True)
class UserRegister:
    """A register that any user of a network may write, and with what.

    Parameters
    ----------
    address : int
    mask : int
        Bits that the ranges are about; the other bits are free.
    ranges : tuple of (int, int)
        Lowest and highest value of the masked bits.
    """
    address: int
    mask: int = 0xFFFF
    ranges: tuple = ((0, 0xFFFF),)

    def takes(self, value):
        """Whether a user may write ``value``."""
        return any(low <= value & self.mask <= high for low, high in self.ranges)


@dataclass(frozen=True)
class Sensor:
    """An image sensor.

    Parameters
    ----------
    name : str
    title : str
        Maker and where one meets it.
    i2c_address : int
        7 bits.
    pointer_bits, value_bits : int
        Bits of a register's address and of a register, 8 or 16, the upper byte first.
    chip_id : tuple of (int, int)
        Registers and what they hold.
    columns, rows : int
        Active pixels.
    bits : int
        Bits of a sample; fewer than 12 are the upper ones of 12.
    bayer : str
        Colours of the active pixels, from the first one on, read without mirrors.
    mirror_keeps_bayer : bool
        Mirrored, the window begins one pixel further, so that the first colour stays if there is an
        even number of columns, or rows.
    black : int
        Sample, of 12 bits, that stands for no light.
    clock_hz, pixel_clock_hz : int
        Usual external clock, and the pixel clock that is made of it.
    test_patterns : dict of str to int
        Name and value for the sensor's register; "Off" is always included.
    limits : Limits
    user_registers : tuple of UserRegister
        What any user of a network may write: exposure, gain and test pattern. None of
        them changes size, position, skipping, clock or Bayer phase of a frame.
    first : (int, int)
        Address of the first active column, and row, from which binned groups are counted.
    waking : Waking
        Reset and rest before the first access.
    controls : Controls
        What users of a network change, and where it is.
    lanes : int
        CSI-2 data lanes; 0: the port is parallel.
    """
    name: str
    title: str
    i2c_address: int
    pointer_bits: int
    value_bits: int
    chip_id: tuple
    columns: int
    rows: int
    bits: int
    bayer: str
    mirror_keeps_bayer: bool
    black: int
    clock_hz: int
    pixel_clock_hz: int
    limits: Limits
    test_patterns: dict = field(default_factory=dict)
    user_registers: tuple = ()
    first: tuple = (0, 0)
    waking: Waking = None
    controls: Controls = None
    lanes: int = 0

    @property
    def last_register(self):
        """The highest address that a register can have."""
        return (1 << self.pointer_bits) - 1

    def user_takes(self, address, value):
        """Whether a user of a network may write ``value`` to ``address``; None: no value at all."""
        one = next((one for one in self.user_registers if one.address == address), None)
        return None if one is None else value < 1 << self.value_bits and one.takes(value)


@dataclass(frozen=True)
class Settings:
    """What is asked of a sensor.

    With ``skip`` above 1, each group of 2 ``skip`` columns sends two samples: those of its first
    two columns, or with ``bins`` above 1 the means of the first ``bins`` even ones, and of as many
    odd ones. So both keep their colour, and lie one active pixel apart. Rows are read alike.

    Parameters
    ----------
    width, height : int
        Samples sent; 0: of all active pixels right of ``left``, below ``top``.
    left, top : int
        Active pixel of the window's corner.
    exposure_us : float
    gain_db : float
    mirror_columns, mirror_rows : bool
        The picture left to right, upside down.
    test_pattern : str
        "Off" or one of the sensor's.
    frames_per_second : float
        0: as many as the exposure allows.
    clock_hz, pixel_clock_hz : int
        External clock and pixel clock; 0: the sensor's usual ones.
    skip : int
        Active columns per sample, and rows.
    bins : int
        Columns whose mean is a sample, and rows; at most ``skip``.
    lane_hz : int
        Bits per second of a CSI-2 lane; 0: the sensor's usual ones, or those that
        ``pixel_clock_hz`` makes.
    """
    width: int = 0
    height: int = 0
    left: int = 0
    top: int = 0
    exposure_us: float = 10_000.0
    gain_db: float = 0.0
    mirror_columns: bool = False
    mirror_rows: bool = False
    test_pattern: str = "Off"
    frames_per_second: float = 0.0
    clock_hz: int = 0
    pixel_clock_hz: int = 0
    skip: int = 1
    bins: int = 1
    lane_hz: int = 0


@dataclass(frozen=True)
class Write:
    """A register write, its purpose, and microseconds to wait after it."""
    register: int
    value: int
    meaning: str
    wait_us: int = 0


@dataclass(frozen=True)
class Timing:
    """When a sensor sends samples: rows of ``width`` of them, ``height`` rows a frame.

    A line takes ``line_clocks`` of the pixel clock, a frame ``frame_lines`` lines.
    """
    width: int
    height: int
    line_clocks: int
    frame_lines: int
    pixel_clock_hz: int

    @property
    def frame_clocks(self):
        """Pixel clocks from the beginning of a frame to that of the next one."""
        return self.line_clocks * self.frame_lines

    @property
    def line_us(self):
        """Microseconds of a line."""
        return 1e6 * self.line_clocks / self.pixel_clock_hz

    @property
    def frames_per_second(self):
        return self.pixel_clock_hz / self.frame_clocks


@dataclass(frozen=True)
class Link:
    """How a sensor sends its samples over CSI-2.

    Parameters
    ----------
    lanes : int
    lane_hz : int
        Bits per second of a lane.
    data_type : DataType
        Of the packets with rows.
    embedded_rows : int
        Packets of embedded data before the first row of a frame.
    """
    lanes: int
    lane_hz: int
    data_type: DataType
    embedded_rows: int = 0

    def row_seconds(self, width, serial=False):
        """Seconds that a row of ``width`` samples takes, with the pause after it; with ``serial``
        also one by one with the clock of the bytes."""
        bits = SAMPLE_BITS_OF[self.data_type] / self.lanes
        return width * max(bits, 8 * serial) / self.lane_hz + _ROW_PAUSE_S


@dataclass(frozen=True)
class Setup:
    """What makes a sensor do what is asked, and what it then does exactly.

    Parameters
    ----------
    sensor : Sensor
    settings : Settings
        As asked, with every 0 that stands for something replaced by it.
    writes : tuple of Write
        In this order.
    timing : Timing
    exposure_clocks : int
        Pixel clocks.
    gain_256 : int
        256 is 1.
    link : Link or None
        None: a parallel port.
    """
    sensor: Sensor
    settings: Settings
    writes: tuple
    timing: Timing
    exposure_clocks: int
    gain_256: int
    link: Link | None = None

    def report(self):
        """The figures under their names in every report."""
        sensor, timing = self.sensor, self.timing
        return {
            "sensor": sensor.name, "i2c_address": sensor.i2c_address,
            "pointer_bits": sensor.pointer_bits, "value_bits": sensor.value_bits,
            "chip_id": [list(pair) for pair in sensor.chip_id],
            "writes": [asdict(write) for write in self.writes],
            "exposure_us": self.exposure_us, "gain_db": self.gain_db, "bayer": self.bayer,
            "black": sensor.black, "line_clocks": timing.line_clocks,
            "frame_lines": timing.frame_lines, "pixel_clock_hz": timing.pixel_clock_hz,
            "frames_per_second": timing.frames_per_second,
            **(asdict(self.link) if self.link else {})}

    @property
    def pairs(self):
        """List of (register, value)."""
        return [(write.register, write.value) for write in self.writes]

    @property
    def exposure_us(self):
        """The exposure one gets, of whole lines, the nearest to what was asked."""
        return 1e6 * self.exposure_clocks / self.timing.pixel_clock_hz

    @property
    def gain_db(self):
        """The gain one gets, the nearest to what was asked, as a factor."""
        return 20 * log10(self.gain_256 / UNITY_GAIN)

    @property
    def bayer(self):
        """Colours of the frame's first pixels; follows from window and mirrors."""
        binned = self.settings.bins - 1         # from the first column of a mean to its centre
        return bayer_at(self.sensor.bayer, self.columns[0] - binned, self.rows[0] - binned)

    @property
    def columns(self):
        """Column of the active pixels for each column of the frame, or the centre of those that are
        averaged. A range if the sensor does not reduce, else a list."""
        asked = self.settings
        return self._read(asked.left, asked.width, asked.mirror_columns)

    @property
    def rows(self):
        """Row of the active pixels for each row of the frame, as :attr:`columns`."""
        asked = self.settings
        return self._read(asked.top, asked.height, asked.mirror_rows)

    def _read(self, begin, size, mirrored):
        asked = self.settings
        if asked.skip > 1:
            begin += asked.bins - 1
            return [begin + asked.skip * (k - k % 2) + k % 2 for k in range(size)]
        if not mirrored:
            return range(begin, begin + size)
        begin += self.sensor.mirror_keeps_bayer
        return range(begin + size - 1, begin - 1, -1)


def bayer_at(bayer, left, top):
    """The pattern ``bayer`` as it begins ``left`` columns and ``top`` rows further on."""
    rows = bayer[:2], bayer[2:]
    rows = rows[top % 2], rows[1 - top % 2]
    return "".join(row[left % 2] + row[1 - left % 2] for row in rows)


def wide(register, value, meaning):
    """Both writes of a number of 16 bits in two registers of 8, the upper one first."""
    return (Write(register, value >> 8, meaning), Write(register + 1, value & 0xFF, meaning))
