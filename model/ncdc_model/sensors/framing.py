"""A sensor's set-up for the raw frames of a geometry."""

from ncdc_model.errors import InputError
from ncdc_model.geometry import MONO
from ncdc_model.sensors.catalogue import sensor_named, setup
from ncdc_model.sensors.sensor import Settings, bayer_at

__all__ = ["setup_around"]


def setup_around(name, geometry, *, clock_hz=None, **settings):
    """:class:`Setup` of a sensor that sends a little more than a raw frame of ``geometry``, and the
    corner (column, row) where that begins, so that its Bayer pattern is the geometry's.

    Parameters
    ----------
    name : str
    geometry : Geometry
    clock_hz : int, optional
        At the sensor's clock pin; by default its usual pixel clock, so that no PLL is needed.
    settings :
        More of :class:`Settings`.

    Raises
    ------
    InputError
        If the sensor cannot, or sends another pattern wherever the frame begins.
    """
    sensor = sensor_named(name)
    step = max(2, sensor.limits.step)
    width, height = (-(-(value + 1) // step) * step for value in geometry.distorted)
    plan = setup(sensor, Settings(width=width, height=height,
                                  clock_hz=clock_hz or sensor.pixel_clock_hz, **settings))
    for corner in ((0, 0), (1, 0), (0, 1), (1, 1)):
        if geometry.bayer in (MONO, bayer_at(plan.bayer, *corner)):
            return plan, corner
    raise InputError(f"the frames are {geometry.bayer}, the {name} sends {plan.bayer}")
