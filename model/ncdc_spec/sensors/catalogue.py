"""The image sensors that we know, by name."""

from ncdc_spec.errors import InputError
from ncdc_spec.sensors import imx219, mt9d111, mt9p031, ov5640, ov5647

__all__ = ["SENSORS", "sensor_named", "setup"]

_MODULES = {module.SENSOR.name: module for module in (
    mt9p031, mt9d111, ov5640, imx219, ov5647)}
SENSORS = tuple(module.SENSOR for module in _MODULES.values())


def sensor_named(name):
    """The :class:`Sensor` of that name; raises :class:`InputError` if there is none."""
    if name not in _MODULES:
        raise InputError(f"the sensor is {name!r}, known are {', '.join(_MODULES)}")
    return _MODULES[name].SENSOR


def setup(sensor, settings):
    """The :class:`Setup` that makes ``sensor`` do what ``settings`` ask; raises :class:`InputError`
    for what the sensor cannot do."""
    return _MODULES[sensor.name].setup(settings)
