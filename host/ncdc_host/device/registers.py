"""The state of a device: the 16-bit words that Table I addresses, and the features in them.

Both protocols read and write these words, so that there is one state, whoever asks.
"""

import threading
from dataclasses import dataclass, replace

from ncdc_host.device.views import Views
from ncdc_spec.colour import Colour
from ncdc_spec.errors import InputError
from ncdc_spec.pixel_formats import BGR8, PixelFormat, bayer_format, format_of_mraw
from ncdc_spec.protocols.auto_control import GAIN_MIN, OFF, Limits
from ncdc_spec.protocols.features import (
    AUTO_FEATURES,
    feature,
    features_of,
    features_with,
    register_number,
    system_word,
)
from ncdc_spec.protocols.table_one import (
    MIRRORS,
    RATE,
    SYSTEM_PAGE,
    SYSTEM_WORDS,
    VIEW,
    VIEWS,
    WINDOW,
)
from ncdc_spec.sensors.catalogue import controlled_sensor, line_ns, window
from ncdc_spec.sensors.controls import number_in
from ncdc_spec.sensors.field import FULL
from ncdc_spec.sensors.framing import field_values, setup_around
from ncdc_spec.sensors.sensor import Settings as Window
from ncdc_spec.view_layout import LAYOUTS
from ncdc_spec.view_matrix import Angles

__all__ = ["Rejected", "Registers", "Settings", "View"]

_EXPOSURE_NS = 10_000_000           # after reset: what the photo was taken with
_WRITABLE = {word.address for word in SYSTEM_WORDS if word.access == "rw"}


def _framing(sensor, geometry, field):
    """Settings of the sensor, and the words of the page that describe them.

    A picture larger than the sensor is emulated too, without a sensor, if no field is named.
    """
    try:
        plan, crop = setup_around(sensor.name, geometry, field=field, clock_hz=sensor.clock_hz)
    except InputError:
        if field not in (None, FULL):
            raise
        settings = Window(clock_hz=sensor.clock_hz, pixel_clock_hz=sensor.pixel_clock_hz)
        return settings, {"SENSOR_WIDTH": 0, "SENSOR_HEIGHT": 0, "DECIMATION_X": 1,
                          "DECIMATION_Y": 1, "FIELD_LEFT": 0, "FIELD_TOP": 0,
                          "SENSOR_ADDRESS": sensor.i2c_address}
    return plan.settings, field_values(plan, crop, geometry)


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
    pattern: str
    rate_tenths: int
    colour: Colour = Colour()
    layout: str = LAYOUTS[0]
    looks: tuple = (Angles(),)          # of the layout's views


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
    sensor : str
        Name of the sensor.
    planes : sequence of PlaneCamera, optional
        Camera of each lens's corrected picture, for a device with a view.

    Attributes
    ----------
    features : tuple of Feature
        Of a device with this sensor, and with :data:`~ncdc_spec.protocols.features.VIEW_FEATURES`
        if it has a view.
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
        If no device with that sensor is emulated, or the raw frames cannot show that part of it.
    """
    def __init__(self, geometry, lenses, rate_tenths, field=None, sensor="mt9p031", planes=()):
        self.lock = threading.RLock()
        self._geometry, self._lens_max = geometry, lenses - 1
        self._on_change = []
        self.bus_accesses = 0
        self._streaming = False
        self._colour = Colour()
        self._views = Views(planes, geometry.corrected)
        self._abilities = WINDOW | MIRRORS | RATE | (VIEW | VIEWS if planes else 0)
        self.auto = dict.fromkeys(AUTO_FEATURES, OFF)
        self.controlled = False
        self._sensor = controlled_sensor(sensor)
        self._use_features(features_with(features_of(self._sensor), self._abilities))
        self._asked, self._field = _framing(self._sensor, geometry, field)
        self._view = self._whole(View(BGR8, 0, 0, 0, 0))
        self._lens, self._rate = 0, rate_tenths
        self._words = {}                # of the sensor's registers, by address
        lines = round(_EXPOSURE_NS / self._line_ns())
        for name, value in (("ExposureTime", lines), ("Gain", GAIN_MIN), ("ReverseX", 0),
                            ("ReverseY", 0)):
            self._put(name, value)
        self.reference_ns = lines * self._line_ns()
        self.dropped = self.torn = 0

    def _use_features(self, features):
        """Compute from the features what each word of the sensor is."""
        self.features = features
        self._feature = {one.name: one for one in features}
        self._shape = {address for one in features if one.locked for address in one.table}
        # Words that the device alone writes while a feature is automatic, and that feature.
        self._automatic = {address: one.locked_by for one in features if one.locked_by
                           for address in one.table}
        self._mirrors = {}              # bits that mirror, by address
        for name in ("ReverseX", "ReverseY"):
            for part in self._feature[name].parts:
                self._mirrors[part.address] = self._mirrors.get(part.address, 0) | part.mask

    def _word(self, address):
        return self._words.get(address, 0)

    def _put(self, name, value):
        """Set a feature in the sensor's registers, unchecked."""
        for part, number in self._feature[name].writes(value):
            self._words[part.address] = part.placed(self._word(part.address), number)

    def _of_sensor(self, name):
        """The register of a feature that is in those of the sensor."""
        return self._feature[name].register(self._word)

    def on_change(self, call):
        """Have ``call()`` called, under the lock, whenever a setting of the picture changed."""
        self._on_change.append(call)

    @property
    def settings(self):
        """The present :class:`Settings`."""
        with self.lock:
            controls = self._sensor.controls
            pattern = controls.pattern_named(number_in(controls.pattern, self._word))
            return Settings(self._view, self._lens, self.lines * self._line_ns(),
                            self._of_sensor("Gain"), pattern, self._rate, self._colour,
                            self._views.layout, self._views.looks)

    @property
    def lines(self):
        """Exposure in lines, at least the sensor's shortest."""
        return max(self._feature["ExposureTime"].low, self._of_sensor("ExposureTime"))

    def limits(self, exposure, gain):
        """The :class:`Limits` of a rule that controls the exposure, the gain or both: the longest
        exposure is one that keeps the frame rate."""
        lines, gains = self._feature["ExposureTime"], self._feature["Gain"]
        frame = 10_000_000_000 // (self._rate * self._line_ns())
        return Limits(exposure, gain, (lines.low, min(max(lines.low, frame), lines.high)),
                      gains.high)

    def possible_gain(self, eighths):
        """The gain that the sensor has if one of ``eighths`` is set."""
        gain = self._sensor.controls.gain
        return gain.eighths(gain.word(eighths))

    def set_exposure(self, lines, gain):
        """Set the exposure in lines and the gain in eighths, as automatic features do."""
        with self.lock:
            self._put("ExposureTime", lines)
            self._put("Gain", gain)
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

    @property
    def has_view(self):
        """Whether the device has a view."""
        return bool(self._views)

    def replace_lens(self, number, descriptor):
        """See :meth:`Views.replace_lens`."""
        with self.lock:
            self._views.replace_lens(number, descriptor)

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
            if address > self._sensor.last_register:
                return 0
            # A device caches what features are in: reading them takes no time on the I2C bus.
            self.bus_accesses += address not in self._sensor.controls.addresses
            return self._window().get(address, self._word(address))

    def write(self, address, value):
        """Write the word at ``address``; raises :class:`Rejected`."""
        with self.lock:
            mirrors = self._mirrors.get(address, 0)
            if not (mirrors or address in _WRITABLE
                    or address < SYSTEM_PAGE
                    and self._sensor.user_takes(address, value) is not None):
                raise Rejected("read only")
            changed = value ^ self.read(address)
            if not changed:
                return
            if mirrors and changed & ~mirrors:
                raise Rejected("read only")
            if self._streaming and address in self._shape:
                raise Rejected("locked")
            if self.controlled and self.auto.get(self._automatic.get(address), OFF) != OFF:
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
            "STREAMING": int(self._streaming), "FRAMES": 0, "ABILITIES": self._abilities,
            **self._field, **self._views.words()}
        for name, value in (("LINE_TIME", line), ("DROPPED", self.dropped), ("TORN", self.torn),
                            ("VIEW_FOCAL", self._views.focal(self._lens))):
            values[f"{name}_UPPER"], values[f"{name}_LOWER"] = value >> 16 & 0xFFFF, value & 0xFFFF
        return {system_word(name): value for name, value in values.items()}

    def _window(self):
        """The sensor's window registers, computed from the picture."""
        view = self._view
        raw = view.pixel_format.raw
        width, height = (view.width, view.height) if raw else self._geometry.distorted
        x, y = (view.x, view.y) if raw else (0, 0)
        asked, step = self._asked, self._sensor.limits.step
        return dict(self._sensor.chip_id) | window(self._sensor, replace(
            asked, left=asked.left + asked.skip * x, top=asked.top + asked.skip * y,
            # Capture cuts off what the sensor sends too much.
            width=-(-width // step) * step, height=-(-height // step) * step))

    def _line_ns(self):
        view = self._view
        columns = view.width if view.pixel_format.raw else self._geometry.distorted_width
        return line_ns(self._sensor, replace(self._asked, width=columns))

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
        elif name in self._views.words():
            try:
                self._views.write(name, value)
            except InputError:
                raise Rejected("value") from None
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
        if self._sensor.user_takes(address, value) is False:
            raise Rejected("value")
        self._words[address] = value
        self.bus_accesses += 1
        if address in self._mirrors:
            self._view = self._present(replace(
                self._view, reverse_x=bool(self._of_sensor("ReverseX")),
                reverse_y=bool(self._of_sensor("ReverseY"))))

    # Features that lie in the words.

    def read_feature(self, one):
        """The 32-bit register of a feature that has ``parts``."""
        with self.lock:
            return one.register(self.read) & 0xFFFFFFFF

    def write_feature(self, one, register):
        """Write the 32-bit register of such a feature; raises :class:`Rejected`."""
        register = register_number(one, register)
        if not one.choices and not one.low <= register <= one.high:
            raise Rejected("value")
        if one.choices and register not in {choice.value for choice in one.choices}:
            raise Rejected("value")
        with self.lock:
            for part, number in one.writes(register):
                self.write(part.address, part.placed(self.read(part.address), number))
