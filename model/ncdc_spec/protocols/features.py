"""The features of a device, declared once: GenICam XML, emulated device, clients and documentation
read this table, and so do registers of either protocol.

A feature is a number in a 32-bit register of the GVCP address space; those with ``parts`` are at
the same time in 16-bit words of the paper's Table I, so that both protocols show one state. Some of
these words are registers of the sensor: :func:`features_of` has the features of each sensor.
"""

from dataclasses import dataclass, replace

from ncdc_spec.eeprom import STATES
from ncdc_spec.pixel_formats import PIXEL_FORMATS
from ncdc_spec.protocols import auto_control, gvsp
from ncdc_spec.protocols.gvcp import BOOTSTRAP, FEATURE_BASE
from ncdc_spec.protocols.table_one import MIRRORS, RATE, SYSTEM_WORDS, VIEW, VIEWS, WINDOW
from ncdc_spec.sensors.controls import Gain, Part, number_in
from ncdc_spec.sensors.grid import MAX_REDUCTION
from ncdc_spec.sensors.mt9p031 import SENSOR
from ncdc_spec.view_layout import LAYOUTS, MAX_SHOWN
from ncdc_spec.view_matrix import LIMITS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY

__all__ = ["AUTO_FEATURES", "FEATURES", "Choice", "Feature", "VIEWS_FEATURES", "VIEW_FEATURES",
           "feature", "features_of", "features_with", "register_number", "system_word"]

_SYSTEM = {word.name: word.address for word in SYSTEM_WORDS}
_BOOTSTRAP = {register.name: register.address for register in BOOTSTRAP}


def system_word(name):
    """Table I address of a word of the system's page."""
    return _SYSTEM[name]


@dataclass(frozen=True)
class Choice:
    """An entry of an enumeration: its value in the GVCP register and in the Table I word."""
    name: str
    value: int
    word: int


@dataclass(frozen=True)
class Feature:
    """One feature.

    Parameters
    ----------
    name : str
        As the Standard Features Naming Convention has it, where it has one.
    kind : str
        "integer", "float", "boolean", "enumeration", "command" or "text".
    address : int
        In the GVCP address space.
    text : str
    category : str
    access : str
        "rw", "ro" or "wo".
    low, high : int
        Limits of the register, a number with a sign if the lower one is negative.
    high_from : tuple of str
        Names of the features whose difference, or the one whose value, bounds the register
        in addition to ``high``.
    step : int
    unit : str
    scale : (int, int)
        A float is register * scale[0] / scale[1].
    scale_from : str
        Name of a feature that also multiplies a float, empty if none does.
    choices : tuple of Choice
    locked : bool
        Whether it cannot be written while pictures stream.
    locked_by : str
        Name of an enumeration; while that is not Off, the device alone writes this feature. Empty
        if there is none.
    selects : tuple of str
        Names of the features whose instances this one selects.
    needs_colour : bool
        Whether only devices whose corrector has gains of the colours show it.
    parts : tuple of Part
        Where it is in words of Table I, the upper bits first; empty if it is in none.
    gain : Gain or None
        How eighths of gain are the number in ``parts``.
    field : (int, int)
        Lowest bit and width of its field in a register that it shares; else empty.
    lacking : bool
        Whether the device's sensor has no such thing: the XML does not list it, and it cannot be
        written.
    length : int
        Bytes of a text.
    """
    name: str
    kind: str
    address: int
    text: str
    category: str
    access: str = "rw"
    low: int = 0
    high: int = 0xFFFFFFFF
    high_from: tuple = ()
    step: int = 1
    unit: str = ""
    scale: tuple = (1, 1)
    scale_from: str = ""
    choices: tuple = ()
    locked: bool = False
    locked_by: str = ""
    selects: tuple = ()
    needs_colour: bool = False
    parts: tuple = ()
    gain: Gain = None
    field: tuple = ()
    lacking: bool = False
    length: int = 4

    @property
    def table(self):
        """Addresses of its words in Table I."""
        return tuple(part.address for part in self.parts)

    def register(self, read):
        """The number in the GVCP register; ``read(address)`` gives a word of Table I."""
        number = number_in(self.parts, read)
        bits = sum(part.width for part in self.parts)
        if self.low < 0 and number >> bits - 1:
            number -= 1 << bits
        if self.gain:
            return self.gain.eighths(number)
        return next((one.value for one in self.choices if one.word == number), number)

    def writes(self, register):
        """The writes that set the GVCP register to ``register``, as a list of (:class:`Part`,
        number): the part takes its bits of the number."""
        number = next((one.word for one in self.choices if one.value == register), register)
        if self.gain:
            number = self.gain.word(register)
        return [(part, number) for part in self.parts]


def _own(index):
    return FEATURE_BASE + 4 * index


def _formats():
    return tuple(Choice(f.name, f.pfnc, f.mraw) for f in PIXEL_FORMATS)


_MODES = (Choice("Continuous", 0, 0), Choice("SingleFrame", 1, 1))
_AUTO = tuple(Choice(name, value, value) for value, name in enumerate(auto_control.MODES))
_RATIOS = tuple(Choice(name, value, value) for value, name in enumerate(("Red", "Green", "Blue")))


def _text(name):
    register = next(register for register in BOOTSTRAP if register.name == name)
    return Feature(name, "text", register.address, "Of the device.", "DeviceControl", access="ro",
                   length=register.length)


def _word(name):
    """Parts of a number that is a word of the system's page."""
    return (Part(_SYSTEM[name]),)


def _upper_lower(name):
    return Part(_SYSTEM[f"{name}_UPPER"], low=16), Part(_SYSTEM[f"{name}_LOWER"])


_STEP = 2       # of offsets and sizes: the colour filter's pattern stays as it is

_ALL = (
    _text("DeviceVendorName"), _text("DeviceModelName"), _text("DeviceVersion"),
    _text("DeviceSerialNumber"), _text("DeviceUserID"),
    Feature("WidthMax", "integer", _own(0), "Width of the whole picture.", "ImageFormatControl",
            access="ro", unit="pixel", parts=_word("WIDTH_MAX")),
    Feature("HeightMax", "integer", _own(1), "Height of the whole picture.", "ImageFormatControl",
            access="ro", unit="pixel", parts=_word("HEIGHT_MAX")),
    Feature("Width", "integer", _own(2), "Width of the picture, a window of the whole one.",
            "ImageFormatControl", low=8, high_from=("WidthMax", "OffsetX"), step=_STEP,
            unit="pixel", locked=True, parts=_word("WIDTH")),
    Feature("Height", "integer", _own(3), "Height of the picture.", "ImageFormatControl", low=8,
            high_from=("HeightMax", "OffsetY"), step=_STEP, unit="pixel", locked=True,
            parts=_word("HEIGHT")),
    Feature("OffsetX", "integer", _own(4), "Column of the whole picture that the picture begins "
            "at.", "ImageFormatControl", high_from=("WidthMax", "Width"), step=_STEP,
            unit="pixel", locked=True, parts=_word("OFFSET_X")),
    Feature("OffsetY", "integer", _own(5), "Row of the whole picture that it begins at.",
            "ImageFormatControl", high_from=("HeightMax", "Height"), step=_STEP, unit="pixel",
            locked=True, parts=_word("OFFSET_Y")),
    Feature("PixelFormat", "enumeration", _own(6), "Raw frames (Bayer formats: the one of the "
            "sensor's present colour filter) or corrected pictures.", "ImageFormatControl",
            choices=_formats(), locked=True, parts=_word("FORMAT")),
    Feature("ReverseX", "boolean", _own(7), "The picture mirrored left to right.",
            "ImageFormatControl", high=1, locked=True),
    Feature("ReverseY", "boolean", _own(8), "The picture upside down.", "ImageFormatControl",
            high=1, locked=True),
    Feature("TestPattern", "enumeration", _own(9), "Picture that the sensor makes itself.",
            "ImageFormatControl"),
    Feature("AcquisitionMode", "enumeration", _own(10), "Pictures until stopped, or one.",
            "AcquisitionControl", choices=_MODES, locked=True),
    Feature("AcquisitionStart", "command", _own(11), "Begin to stream.", "AcquisitionControl",
            access="wo", high=1),
    Feature("AcquisitionStop", "command", _own(12), "End the stream.", "AcquisitionControl",
            access="wo", high=1),
    Feature("AcquisitionFrameRate", "float", _own(13), "Frames per second.", "AcquisitionControl",
            low=1, high=1200, unit="Hz", scale=(1, 10), parts=_word("FRAME_RATE")),
    Feature("LineTime", "integer", _own(14), "Time in which the sensor reads one line: the step "
            "of the exposure.", "AcquisitionControl", access="ro", unit="ns",
            parts=_upper_lower("LINE_TIME")),
    Feature("ExposureTime", "float", _own(15), "Exposure; the register counts lines.",
            "AcquisitionControl", unit="us", scale=(1, 1000), scale_from="LineTime",
            locked_by="ExposureAuto"),
    Feature("Gain", "float", _own(16), "Analog gain, a factor.", "AnalogControl", low=8,
            scale=(1, 8), locked_by="GainAuto"),
    Feature("CorrectionEnable", "boolean", _own(17), "Corrected pictures (1) or raw frames (0); "
            "changes PixelFormat to BGR8 or to the sensor's, and back to the whole picture.",
            "NcdcControl", high=1, locked=True, parts=_word("SOURCE")),
    Feature("LensSelector", "integer", _own(18), "Number of the lens that is corrected; takes "
            "effect with the next frame.", "NcdcControl", high=0xFFFE, high_from=("LensMax",),
            parts=_word("LENS")),
    Feature("LensMax", "integer", _own(19), "Number of the last lens.", "NcdcControl",
            access="ro", parts=_word("LENS_MAX")),
    Feature("SensorRegisterAddress", "integer", _own(20), "Table I address that "
            "SensorRegisterValue reads and writes.", "NcdcControl", high=0xFFFF),
    Feature("SensorRegisterValue", "integer", _own(21), "The 16-bit word there.", "NcdcControl",
            high=0xFFFF),
    Feature("FramesDropped", "integer", _own(22), "Frames that were due and not made in time.",
            "NcdcControl", access="ro", parts=_upper_lower("DROPPED")),
    Feature("FramesTorn", "integer", _own(23), "Frames that were overwritten while they were "
            "read.", "NcdcControl", access="ro", parts=_upper_lower("TORN")),
    Feature("PayloadSize", "integer", _own(24), "Bytes of a picture.", "TransportLayerControl",
            access="ro", unit="byte"),
    Feature("TLParamsLocked", "integer", _own(25), "1: what the size of a picture depends on is "
            "locked.", "TransportLayerControl", high=1),
    Feature("TriggerSelector", "enumeration", _own(26), "What a trigger begins.",
            "AcquisitionControl", high=0, choices=(Choice("FrameStart", 0, 0),)),
    Feature("TriggerMode", "enumeration", _own(27), "On: each trigger sends one picture, whose "
            "exposure begins after it.", "AcquisitionControl", high=1, locked=True,
            choices=(Choice("Off", 0, 0), Choice("On", 1, 1))),
    Feature("TriggerSource", "enumeration", _own(28), "Where triggers come from.",
            "AcquisitionControl", high=0, choices=(Choice("Software", 0, 0),)),
    Feature("TriggerSoftware", "command", _own(29), "Send the next picture, while TriggerMode is "
            "On; a trigger that comes before it is sent does nothing.", "AcquisitionControl",
            access="wo", high=1),
    Feature("SensorWidth", "integer", _own(30), "Active columns of the sensor.",
            "ImageFormatControl", access="ro", unit="pixel", parts=_word("SENSOR_WIDTH")),
    Feature("SensorHeight", "integer", _own(31), "Active rows of the sensor.",
            "ImageFormatControl", access="ro", unit="pixel", parts=_word("SENSOR_HEIGHT")),
    Feature("DecimationHorizontal", "integer", _own(32), "Active columns for each of a whole "
            "raw frame.",
            "ImageFormatControl", access="ro", low=1, high=MAX_REDUCTION,
            parts=_word("DECIMATION_X")),
    Feature("DecimationVertical", "integer", _own(33), "Active rows for each of a whole raw "
            "frame.", "ImageFormatControl", access="ro", low=1,
            high=MAX_REDUCTION, parts=_word("DECIMATION_Y")),
    Feature("FieldLeft", "integer", _own(34), "Active column where whole raw frames begin.",
            "NcdcControl", access="ro", unit="pixel", parts=_word("FIELD_LEFT")),
    Feature("FieldTop", "integer", _own(35), "Active row where whole raw frames begin.",
            "NcdcControl", access="ro", unit="pixel", parts=_word("FIELD_TOP")),
    Feature("ExposureAuto", "enumeration", _own(36), "Once and Continuous: while pictures stream, "
            "the device sets ExposureTime by the mean of raw samples, up to the time of a frame. "
            "Once becomes Off when it has settled.",
            "AcquisitionControl", high=auto_control.CONTINUOUS, choices=_AUTO),
    Feature("GainAuto", "enumeration", _own(37), "Likewise Gain; together with ExposureAuto, the "
            "gain rises only when the exposure is at its longest.", "AnalogControl",
            high=auto_control.CONTINUOUS, choices=_AUTO),
    Feature("BalanceWhiteAuto", "enumeration", _own(38), "Once and Continuous: while corrected "
            "pictures stream, the device sets BalanceRatio so that the colours have equal "
            "means.", "AnalogControl", high=auto_control.CONTINUOUS,
            choices=_AUTO, needs_colour=True),
    Feature("BalanceRatioSelector", "enumeration", _own(39), "Colour that BalanceRatio is of.",
            "AnalogControl", high=len(_RATIOS) - 1, choices=_RATIOS, selects=("BalanceRatio",),
            needs_colour=True),
    Feature("BalanceRatio", "float", _own(40), "Gain of a colour's raw samples, before "
            "interpolation, a factor: raw frames have it too.", "AnalogControl", low=1,
            high=LARGEST_GAIN, scale=(1, UNITY), locked_by="BalanceWhiteAuto", needs_colour=True),
    Feature("GevSCPSPacketSize", "integer", _BOOTSTRAP["StreamPacketSize"], "Bytes of a packet "
            "with IP and UDP header.", "TransportLayerControl",
            low=gvsp.packet_size(gvsp.MIN_PACKET + gvsp.PAYLOAD_STEP - 1),
            high=gvsp.packet_size(gvsp.MAX_PACKET), step=gvsp.PAYLOAD_STEP,
            unit="byte", locked=True, field=(0, 16)),
    Feature("GevSCPD", "integer", _BOOTSTRAP["StreamPacketDelay"], "Delay between two packets.",
            "TransportLayerControl", high=1_000_000, unit="ns"),
    Feature("EepromStatus", "enumeration", _BOOTSTRAP["EepromStatus"], "Loaded: the first lens is "
            "that of the camera's EEPROM; else why it is the built-in one.", "NcdcControl",
            access="ro", high=len(STATES) - 1,
            choices=tuple(Choice(name, k, k) for k, name in enumerate(STATES))),
)


def _of_sensor(controls, limits):
    """What the features have that are in the sensor's registers, by their names; None: it lacks
    them."""
    mirrors = {name: mirror and {"parts": mirror.parts, "choices": (
        Choice("Off", 0, mirror.plain), Choice("On", 1, mirror.mirrored))}
        for name, mirror in (("ReverseX", controls.mirror_columns),
                             ("ReverseY", controls.mirror_rows))}
    patterns = (Choice("Off", 0, 0), *(
        Choice(name, number, number) for name, number in controls.patterns.items()))
    return mirrors | {
        "ExposureTime": {"parts": controls.exposure, "low": limits.lines[0],
                         "high": limits.lines[1]},
        "Gain": {"parts": controls.gain.parts, "gain": controls.gain, "high": controls.gain.high},
        "TestPattern": controls.pattern and {"parts": controls.pattern, "choices": patterns}}


def features_of(sensor, lines_max=None):
    """The :class:`Feature` of each register of a device with that :class:`Sensor`.

    Parameters
    ----------
    sensor : Sensor
    lines_max : int, optional
        The longest exposure, in lines, if it is less than the sensor's.
    """
    given = _of_sensor(sensor.controls, sensor.limits)
    if lines_max is not None:
        given["ExposureTime"]["high"] = lines_max
    return tuple(
        one if one.name not in given else
        replace(one, **given[one.name]) if given[one.name] else
        replace(one, access="ro", lacking=True) for one in _ALL)


FEATURES = features_of(SENSOR)
"""Features of a device with an MT9P031."""


_ABILITIES = {WINDOW: ("Width", "Height", "OffsetX", "OffsetY"), MIRRORS: ("ReverseX", "ReverseY"),
              RATE: ("AcquisitionFrameRate",)}


def features_with(features, abilities):
    """``features``, :data:`VIEW_FEATURES` and :data:`VIEWS_FEATURES`, as a device of those
    ``abilities`` has them.

    Parameters
    ----------
    features : sequence of Feature
    abilities : int
        Value of the word ABILITIES. Without mirrors the features are lacking; without a window
        or a rate they are read-only.
    """
    missing = {name: bit for bit, names in _ABILITIES.items() if not abilities & bit
               for name in names}
    found = tuple(one if one.name not in missing else
                  replace(one, lacking=True) if missing[one.name] == MIRRORS else
                  replace(one, access="ro") for one in features)
    return (found + (VIEW_FEATURES if abilities & VIEW else ())
            + (VIEWS_FEATURES if abilities & VIEWS else ()))


def _looking(name, index, text, steps, unit="deg"):
    """The feature of one number of :class:`ncdc_spec.view_matrix.Angles`, ``steps`` a unit."""
    low, high = (round(steps * value) for value in LIMITS[name.lower()])
    return Feature(name, "float", _own(index), text, "NcdcControl", low=low, high=high, unit=unit,
                   scale=(1, steps), parts=_word(name.upper()))


VIEW_FEATURES = (
    _looking("Pan", 41, "Direction in which corrected pictures look, to the right.", 100),
    _looking("Tilt", 42, "The same, upwards.", 100),
    _looking("Roll", 43, "Turn of the view about its own axis, clockwise.", 100),
    _looking("Zoom", 44, "Magnification, 1 as trained.", 1000, unit=""),
    Feature("ViewFocal", "float", _own(45), "Focal length of corrected pictures at Zoom 1; 0: "
            "the lens does not state it, and is shown as trained.",
            "NcdcControl", access="ro", unit="pixel", scale=(1, 100),
            parts=_upper_lower("VIEW_FOCAL")),
)
"""Further features of a device whose corrector has a view, and whose lenses state their focal
length."""

VIEWS_FEATURES = (
    Feature("ViewLayout", "enumeration", _own(46), "Views in a corrected picture: one, four of "
            "equal size, or one with a second one in its corner.", "NcdcControl",
            choices=tuple(Choice(name, k, k) for k, name in enumerate(LAYOUTS)),
            parts=_word("VIEW_LAYOUT")),
    Feature("ViewSelector", "enumeration", _own(47), "View that Pan, Tilt, Roll and Zoom are of, "
            "by its position: rows from the top, each from the left.", "NcdcControl",
            choices=tuple(Choice(f"View{k}", k, k) for k in range(MAX_SHOWN)),
            selects=("Pan", "Tilt", "Roll", "Zoom"), parts=_word("VIEW_SELECTED")),
)
"""Further features of a device that shows several views in one picture."""

_BY_NAME = {feature.name: feature for feature in (*FEATURES, *VIEW_FEATURES, *VIEWS_FEATURES)}

AUTO_FEATURES = tuple(one.name for one in FEATURES if one.choices == _AUTO)


def feature(name):
    """The :class:`Feature` of that name; raises :class:`KeyError`."""
    return _BY_NAME[name]


def register_number(one, word):
    """The number that a 32-bit register of the feature ``one`` holds, with its sign."""
    return word - (1 << 32) if one.low < 0 and word >> 31 else word
