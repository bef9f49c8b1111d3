"""The state of a device: the 16-bit words that Table I addresses, and the features in them.

Both protocols read and write these words, so that there is one state, whoever asks.
"""

import threading
from dataclasses import dataclass, replace

from ncdc_spec.colour import Colour
from ncdc_spec.errors import InputError
from ncdc_spec.pixel_formats import BGR8, PixelFormat, bayer_format, format_of_mraw
from ncdc_spec.protocols.auto_control import OFF
from ncdc_spec.protocols.features import (
    AUTO_FEATURES,
    FEATURES,
    VIEW_FEATURES,
    feature,
    system_word,
)
from ncdc_spec.protocols.table_one import SYSTEM_PAGE, SYSTEM_WORDS
from ncdc_spec.sensors import mt9p031 as sensor
from ncdc_spec.sensors.field import FULL
from ncdc_spec.sensors.framing import field_values, setup_around
from ncdc_spec.sensors.sensor import Settings as Window
from ncdc_spec.view_matrix import Angles

__all__ = ["Rejected", "Registers", "Settings", "View"]

_SENSOR_REGISTERS = 0x100           # further addresses answer nothing: read as 0
_CLOCK_HZ = sensor.SENSOR.clock_hz
_EXPOSURE_NS = 10_000_000           # after reset: what the photo was taken with
_MIRRORS = 1 << sensor.MIRROR_ROW | 1 << sensor.MIRROR_COLUMN     # of READ_MODE_2
# All that may be written, of the sensor and of the system's page.
_WRITABLE = {sensor.READ_MODE_2, *(one.address for one in sensor.SENSOR.user_registers)} | {
    word.address for word in SYSTEM_WORDS if word.access == "rw"}
# Sensor registers that a device caches, so that reading them takes no time on the I2C bus.
_CACHED = {sensor.SHUTTER_UPPER, sensor.SHUTTER_LOWER, sensor.GLOBAL_GAIN, sensor.TEST_PATTERN}
_SHAPE = {address for one in FEATURES if one.locked for address in one.table}
# Words that the device alone writes while a feature is automatic, and that feature.
_AUTOMATIC = {address: one.locked_by for one in FEATURES if one.locked_by for address in one.table}


def _framing(geometry, field):
    """Settings of an MT9P031, and the words of the page that describe them.

    A picture larger than the sensor is emulated too, without a sensor, if no field is named.
    """
    try:
        plan, crop = setup_around(sensor.SENSOR.name, geometry, field=field, clock_hz=_CLOCK_HZ)
    except InputError:
        if field not in (None, FULL):
            raise
        return Window(), {"SENSOR_WIDTH": 0, "SENSOR_HEIGHT": 0, "DECIMATION_X": 1,
                          "DECIMATION_Y": 1, "FIELD_LEFT": 0, "FIELD_TOP": 0}
    return plan.settings, field_values(plan, crop, geometry)


def _angles_of(numbers):
    """The :class:`Angles` of the registers of :data:`VIEW_FEATURES`, by name."""
    return Angles(**{name.lower(): number / feature(name).scale[1]
                     for name, number in numbers.items()})


class Rejected(Exception):
    """A write that the device does not carry out.

    Parameters
    ----------
    reason : str
        "value": outside the limits; "locked": pictures stream, or the feature is automatic;
        "read only".
    """
    def __init__(self, reason):
        super().__init__(reason)
        self.reason = reason


@dataclass(frozen=True)
class View:
    """Which part of which picture goes out, and how.

    Parameters
    ----------
    pixel_format : PixelFormat
    x, y, width, height : int
        Window of the whole picture, mirrored already.
    reverse_x, reverse_y : bool
    """
    pixel_format: PixelFormat
    x: int
    y: int
    width: int
    height: int
    reverse_x: bool = False
    reverse_y: bool = False

    @property
    def size(self):
        """Bytes of the picture."""
        return self.width * self.height * self.pixel_format.pixel_bytes


@dataclass(frozen=True)
class Settings:
    """Settings of a frame, as they were when it began."""
    view: View
    lens: int
    exposure_ns: int
    gain_eighths: int
    pattern: int
    rate_tenths: int
    colour: Colour = Colour()
    angles: Angles = Angles()


class Registers:
    """The words, under one lock; every write is checked, and applied or rejected as a whole.

    Parameters
    ----------
    geometry : Geometry
        Geometry of every lens of the device.
    lenses : int
    rate_tenths : int
        Frames per second after reset, tenths.
    field : str, optional
        Part of the sensor that raw frames show, as of
        :func:`ncdc_spec.sensors.framing.setup_around`.
    planes : sequence of PlaneCamera, optional
        Camera of each lens's corrected picture, for a device with a view.

    Attributes
    ----------
    has_view : bool
        Whether there are :data:`~ncdc_spec.protocols.features.VIEW_FEATURES`.
    lock : RLock
        Held by who needs several words at one time.
    auto : dict of str to int
        Value of each automatic feature, by its name.
    controlled : bool
        Whether a user of GVCP has control. Without one nothing automatic is locked.
    bus_accesses : int
        Accesses so far that take time on the sensor's I2C bus in a device that has one.
    reference_ns : int
        Exposure time after reset, at which the light is as in the photo.

    Raises
    ------
    InputError
        If the raw frames cannot show that part of the sensor.
    """
    def __init__(self, geometry, lenses, rate_tenths, field=None, planes=()):
        self.lock = threading.RLock()
        self._geometry, self._lens_max = geometry, lenses - 1
        self._on_change = []
        self.bus_accesses = 0
        self._streaming = False
        self._colour = Colour()
        self.has_view, self._planes = bool(planes), planes
        self._angles = {one.name: round(getattr(Angles(), one.name.lower()) * one.scale[1])
                        for one in VIEW_FEATURES if one.access == "rw"}
        self.auto = dict.fromkeys(AUTO_FEATURES, OFF)
        self.controlled = False
        self._asked, self._field = _framing(geometry, field)
        self._view = self._whole(View(BGR8, 0, 0, 0, 0))
        self._lens, self._rate = 0, rate_tenths
        self._sensor = [0] * _SENSOR_REGISTERS
        self._sensor[sensor.GLOBAL_GAIN] = 8
        self.reference_ns = self._set_lines(round(_EXPOSURE_NS / self._line_ns()))
        self.dropped = self.torn = 0

    def _set_lines(self, lines):
        self._sensor[sensor.SHUTTER_UPPER], self._sensor[sensor.SHUTTER_LOWER] = divmod(lines,
                                                                                       1 << 16)
        return lines * self._line_ns()

    def on_change(self, call):
        """Have ``call()`` called, under the lock, whenever a setting of the picture changed."""
        self._on_change.append(call)

    @property
    def settings(self):
        """The present :class:`Settings`."""
        with self.lock:
            word = self._sensor
            gain = max(8, word[sensor.GLOBAL_GAIN] & 63)
            return Settings(self._view, self._lens, self.lines * self._line_ns(), gain,
                            word[sensor.TEST_PATTERN], self._rate, self._colour,
                            _angles_of(self._angles))

    @property
    def lines(self):
        """Exposure in lines, at least 1."""
        word = self._sensor
        return max(1, word[sensor.SHUTTER_UPPER] << 16 | word[sensor.SHUTTER_LOWER])

    @property
    def lines_per_frame(self):
        """Lines of the longest exposure that keeps the frame rate, at least 1."""
        lines = 10_000_000_000 // (self._rate * self._line_ns())
        return min(max(1, lines), feature("ExposureTime").high)

    def set_exposure(self, lines, gain):
        """Set the exposure in lines and the gain in eighths, as automatic features do."""
        with self.lock:
            self._set_lines(lines)
            low, width = sensor.ANALOG_GAIN
            self._sensor[sensor.GLOBAL_GAIN] &= ~((1 << width) - 1 << low)
            self._sensor[sensor.GLOBAL_GAIN] |= gain << low
            self._change()

    def set_colour(self, colour):
        """Have pictures made with this :class:`Colour` from the next frame on."""
        with self.lock:
            if colour != self._colour:
                self._colour = colour
                self._change()

    def set_ratio(self, selected, gain):
        """Set the gain at capture of one colour, in 256ths; raises :class:`Rejected`."""
        with self.lock:
            gains = list(self._colour.raw_gains)
            if gains[selected] == gain:
                return
            if self.auto["BalanceWhiteAuto"] != OFF:
                raise Rejected("locked")
            gains[selected] = gain
            self.set_colour(replace(self._colour, raw_gains=tuple(gains)))

    def read_angle(self, one):
        """The number in the register of one of the view's features."""
        with self.lock:
            if one.name == "ViewFocal":
                return round(self._planes[self._lens].focal * one.scale[1])
            return self._angles[one.name]

    def write_angle(self, one, number):
        """Write such a register, within its limits; raises :class:`Rejected` if a lens cannot look
        so far off its axis."""
        with self.lock:
            wanted = self._angles | {one.name: number}
            try:
                for plane in self._planes:
                    plane.looking(_angles_of(wanted))
            except InputError:
                raise Rejected("value") from None
            if wanted != self._angles:
                self._angles = wanted
                self._change()

    def _change(self):
        for call in self._on_change:
            call()

    @property
    def streaming(self):
        """Whether pictures stream, so that their size and format are locked."""
        return self._streaming

    @streaming.setter
    def streaming(self, value):
        with self.lock:
            self._streaming = value

    # Words of Table I.

    def read(self, address):
        """The word at ``address``; 0 where there is none."""
        with self.lock:
            if address >= SYSTEM_PAGE:
                return self._system().get(address, 0)
            if address >= _SENSOR_REGISTERS:
                return 0
            self.bus_accesses += address not in _CACHED
            return self._window().get(address, self._sensor[address])

    def write(self, address, value):
        """Write the word at ``address``; raises :class:`Rejected`."""
        with self.lock:
            if address not in _WRITABLE:
                raise Rejected("read only")
            changed = value ^ self.read(address)
            if not changed:
                return
            if address == sensor.READ_MODE_2 and changed & ~_MIRRORS:
                raise Rejected("read only")
            if self._streaming and address in _SHAPE:
                raise Rejected("locked")
            if self.controlled and self.auto.get(_AUTOMATIC.get(address), OFF) != OFF:
                raise Rejected("locked")
            if address >= SYSTEM_PAGE:
                self._write_system(address, value)
            else:
                self._write_sensor(address, value)
            self._change()

    def _system(self):
        view, line = self._view, self._line_ns()
        whole = self._whole(view)
        values = {
            "SOURCE": int(not view.pixel_format.raw), "WIDTH": view.width, "HEIGHT": view.height,
            "FORMAT": self._present(view).pixel_format.mraw, "FRAME_RATE": self._rate,
            "LENS": self._lens, "OFFSET_X": view.x, "OFFSET_Y": view.y,
            "WIDTH_MAX": whole.width, "HEIGHT_MAX": whole.height, "LENS_MAX": self._lens_max,
            "STREAMING": int(self._streaming), "FRAMES": 0, **self._field}
        for name, value in (("LINE_TIME", line), ("DROPPED", self.dropped), ("TORN", self.torn)):
            values[f"{name}_UPPER"], values[f"{name}_LOWER"] = value >> 16 & 0xFFFF, value & 0xFFFF
        return {system_word(name): value for name, value in values.items()}

    def _window(self):
        """The sensor's window registers, computed from the picture."""
        view = self._view
        raw = view.pixel_format.raw
        width, height = (view.width, view.height) if raw else self._geometry.distorted
        x, y = (view.x, view.y) if raw else (0, 0)
        skip = self._asked.skip
        mode = sensor.mode_word(self._asked)
        return {sensor.CHIP_VERSION: sensor.CHIP_VERSION_VALUE,
                sensor.ROW_START: sensor.FIRST_ROW + self._asked.top + skip * y,
                sensor.COLUMN_START: sensor.FIRST_COLUMN + self._asked.left + skip * x,
                sensor.ROW_SIZE: skip * height - 1, sensor.COLUMN_SIZE: skip * width - 1,
                sensor.ROW_MODE: mode, sensor.COLUMN_MODE: mode}

    def _line_ns(self):
        view = self._view
        columns = view.width if view.pixel_format.raw else self._geometry.distorted_width
        return sensor.line_time_ns(columns, self._asked.bins)

    def _whole(self, view):
        """``view`` without a window."""
        width, height = (self._geometry.distorted if view.pixel_format.raw
                         else self._geometry.corrected)
        return replace(view, x=0, y=0, width=width, height=height)

    def _present(self, view):
        """``view`` with the raw format that its mirroring gives: the pattern's first sample moves.

        Sides and offsets are even, so that each mirroring swaps the columns' or the rows' colours.
        """
        if not view.pixel_format.raw:
            return view
        pattern = self._geometry.bayer
        if view.reverse_x:
            pattern = pattern[1] + pattern[0] + pattern[3] + pattern[2]
        if view.reverse_y:
            pattern = pattern[2:] + pattern[:2]
        return replace(view, pixel_format=bayer_format(pattern))

    def _write_system(self, address, value):
        name = {system_word(word.name): word.name for word in SYSTEM_WORDS}.get(address)
        if name in ("WIDTH", "HEIGHT", "OFFSET_X", "OFFSET_Y"):
            self._view = self._resized(name, value)
        elif name == "SOURCE":
            if value > 1:
                raise Rejected("value")
            pixel_format = BGR8 if value else bayer_format(self._geometry.bayer)
            self._view = self._present(self._whole(replace(self._view,
                                                           pixel_format=pixel_format)))
        elif name == "FORMAT":
            self._view = self._reformatted(value)
        elif name == "FRAME_RATE":
            limits = feature("AcquisitionFrameRate")
            if not limits.low <= value <= limits.high:
                raise Rejected("value")
            self._rate = value
        elif name == "LENS":
            if value > self._lens_max:
                raise Rejected("value")
            self._lens = value
        else:
            raise Rejected("read only")

    def _resized(self, name, value):
        key = {"WIDTH": "width", "HEIGHT": "height", "OFFSET_X": "x", "OFFSET_Y": "y"}[name]
        view, whole = replace(self._view, **{key: value}), self._whole(self._view)
        if (value % 2 or view.width < 8 or view.height < 8 or view.x + view.width > whole.width
                or view.y + view.height > whole.height):
            raise Rejected("value")
        return view

    def _reformatted(self, mraw):
        try:
            pixel_format = format_of_mraw(mraw)
        except InputError:
            raise Rejected("value") from None
        view = replace(self._view, pixel_format=pixel_format)
        if pixel_format.raw and self._present(view).pixel_format != pixel_format:
            raise Rejected("value")      # the sensor's filter is another one
        return view if pixel_format.raw == self._view.pixel_format.raw else self._whole(view)

    def _write_sensor(self, address, value):
        if sensor.SENSOR.user_takes(address, value) is False:
            raise Rejected("value")
        self._sensor[address] = value
        self.bus_accesses += 1
        if address == sensor.READ_MODE_2:
            self._view = self._present(replace(
                self._view, reverse_x=bool(value >> sensor.MIRROR_COLUMN & 1),
                reverse_y=bool(value >> sensor.MIRROR_ROW & 1)))

    # Features that lie in the words.

    def read_feature(self, one):
        """The 32-bit register of a feature that has a ``table``."""
        with self.lock:
            value = 0
            for address in one.table:
                value = value << 16 | self.read(address)
            if one.field:
                lowest, width = one.field
                value = value >> lowest & (1 << width) - 1
            return one.register_of(value)

    def write_feature(self, one, register):
        """Write the 32-bit register of such a feature; raises :class:`Rejected`."""
        if not one.choices and not one.low <= register <= one.high:
            raise Rejected("value")
        if one.choices and register not in {choice.value for choice in one.choices}:
            raise Rejected("value")
        value = one.word_of(register)
        with self.lock:
            if one.field:
                lowest, width = one.field
                mask = (1 << width) - 1 << lowest
                value = self.read(one.table[0]) & ~mask | value << lowest
            for k, address in enumerate(reversed(one.table)):
                self.write(address, value >> 16 * k & 0xFFFF)
