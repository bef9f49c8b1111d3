"""The image sensors that we know, by name."""

from ncdc_spec.errors import InputError
from ncdc_spec.sensors import imx219, mt9d111, mt9p031, ov5640, ov5647

__all__ = ["SENSORS", "controlled_sensor", "line_ns", "sensor_at", "sensor_named", "setup",
           "window"]

_MODULES = {module.SENSOR.name: module for module in (
    mt9p031, mt9d111, ov5640, imx219, ov5647)}
SENSORS = tuple(module.SENSOR for module in _MODULES.values())


def sensor_named(name):
    """The :class:`Sensor` of that name; raises :class:`InputError` if there is none."""
    if name not in _MODULES:
        raise InputError(f"the sensor is {name!r}, known are {', '.join(_MODULES)}")
    return _MODULES[name].SENSOR


def controlled_sensor(name):
    """The :class:`Sensor` of that name, whose settings a device on a network changes; raises
    :class:`InputError` if there is none."""
    known = {one.name: one for one in SENSORS if one.controls}
    if name not in known:
        raise InputError(f"the sensor is {name!r}, a device on a network has one of "
                         f"{', '.join(known)}")
    return known[name]


def sensor_at(i2c_address):
    """The :class:`Sensor` with that I2C address; None if there is none."""
    return next((one for one in SENSORS if one.i2c_address == i2c_address), None)


def setup(sensor, settings):
    """The :class:`Setup` that makes ``sensor`` do what ``settings`` ask; raises :class:`InputError`
    for what the sensor cannot do."""
    return _MODULES[sensor.name].setup(settings)


def window(sensor, settings):
    """Registers of the window of ``sensor`` for complete ``settings``, as a dict by address."""
    return {write.register: write.value for write in _MODULES[sensor.name].window(settings)}


def line_ns(sensor, settings):
    """Nanoseconds of a line of ``sensor`` for complete ``settings``, rounded."""
    clocks = _MODULES[sensor.name].line_of(settings)
    return round(10**9 * clocks / settings.pixel_clock_hz)
