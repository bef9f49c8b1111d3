"""A sensor's configuration for the raw frames of a geometry, and capture of its frames."""

from itertools import product
from typing import NamedTuple

from ncdc_spec.camera_port import CSI2, CameraPort
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MONO
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.field import Field, Way, field_named, ways_of
from ncdc_spec.sensors.grid import MAX_REDUCTION, grid_weight, gridded
from ncdc_spec.sensors.sensor import Settings, Timing, bayer_at

__all__ = ["Crop", "camera_of", "field_values", "grid_offset", "grid_row", "setup_around", "shown"]

_SMOOTH_HZ = 15         # frames per second from which on movement looks continuous
_DROPPED = 2            # columns and rows that the evened grid loses at its end


class Crop(NamedTuple):
    """Processing of a sensor's frame by capture: an even grid, and the raw frame as a part of it.

    Parameters
    ----------
    left, top : int
        First column and row of the raw frame in the output of the grid stage.
    weight, binning : int
        Arguments of :func:`~ncdc_spec.sensors.grid.gridded`; 0 and 0: no grid stage.
    """
    left: int
    top: int
    weight: int = 0
    binning: int = 0

    @property
    def grid(self):
        """Whether the grid stage is needed."""
        return bool(self.weight or self.binning)

    def arriving(self, timing):
        """The :class:`Timing` with which samples leave the grid stage: binned, half as often."""
        if not self.binning:
            return timing
        return Timing(timing.width // 2, timing.height // 2, timing.line_clocks,
                      -(-timing.frame_lines // 2), timing.pixel_clock_hz // 2)

    def raw(self, frames, size):
        """Raw frames (frames, height, width), 12-bit samples, of the frames that a sensor sends.

        Parameters
        ----------
        frames : array of integers, shape (frames, height, width)
        size : (int, int)
            Width and height of a raw frame.
        """
        width, height = size
        return [(gridded(frame, self.weight, self.binning) if self.grid else frame)[
            self.top:self.top + height, self.left:self.left + width] for frame in frames]


def setup_around(name, geometry, *, field=None, clock_hz=None, **settings):
    """(:class:`Setup`, :class:`Crop`) of a sensor whose frames hold a raw frame of ``geometry``,
    in its Bayer pattern, and a little more.

    The sensor skips as far as it can, and bins as much as still leaves 15 frames per second: each
    bin costs the time to read its rows, and skipping alone has more aliasing. Below 15 it sends as
    many as it can.

    Parameters
    ----------
    name : str
    geometry : Geometry
    field : str, optional
        Part of the sensor that the raw frames show, as of
        :func:`~ncdc_spec.sensors.field.field_named`, reduced to their size: ``full`` is the
        largest one of their shape. A corner is moved to the nearest one that the colours allow.
        None: the middle, pixel by pixel.
    clock_hz : int, optional
        At the sensor's clock pin; by default its usual pixel clock, so that no PLL is needed. A
        sensor with CSI-2 has its usual clock.
    settings :
        More of :class:`Settings`.

    Raises
    ------
    InputError
        If the sensor cannot, or sends another pattern wherever the frame begins.
    """
    sensor = sensor_named(name)
    wanted = Field(geometry.distorted) if field is None else field_named(field)
    ways = _fitting_ways(sensor, geometry, settings)
    if wanted.size is None:
        wanted = Field(tuple(max(ways) * part for part in geometry.distorted))
    way = _way_to(sensor, geometry, wanted, ways)
    _check_corner(sensor, wanted)
    usual = sensor.clock_hz if sensor.lanes else sensor.pixel_clock_hz
    common = {"clock_hz": clock_hz or usual, **settings}
    return _smooth([_positioned(sensor, geometry, way, bins, wanted, common)
                    for bins in _bins(sensor, geometry, way)])


def camera_of(plan, crop):
    """The :class:`CameraPort` for a sensor's configuration and what capture makes of its frames; a
    PHY for CSI-2 is elsewhere."""
    return CameraPort(CSI2, plan.link.lanes, serial=crop.grid) if plan.link else CameraPort()


def grid_row(plan, crop):
    """Samples of a row that the grid stage has to take; None if it is not needed."""
    return plan.timing.width if Crop(*crop).grid else None


def shown(plan, crop, geometry):
    """(left, top, width, height) of the active pixels that the raw frames show."""
    asked, way = plan.settings, Way(plan.settings.skip, crop.binning)
    size = [way.reduction * part for part in geometry.distorted]
    if way.reduction == 1:
        # Mirrored, the first column of a frame is the last one of its window.
        begins = [min(line[corner], line[corner + part - 1]) for line, corner, part in zip(
            (plan.columns, plan.rows), crop[:2], geometry.distorted)]
    else:
        begins = [begin + way.reduction * corner + grid_offset(plan, crop)
                  for begin, corner in zip((asked.left, asked.top), crop[:2])]
    return (*begins, *size)


def field_values(plan, crop, geometry):
    """The words of the system's page that say which sensor it is, and which part of it raw frames
    show, by name. Where an even grid begins outside of the sensor, they begin with it."""
    left, top, *_ = shown(plan, crop, geometry)
    reduction = plan.settings.skip << crop.binning
    return {"SENSOR_WIDTH": plan.sensor.columns, "SENSOR_HEIGHT": plan.sensor.rows,
            "DECIMATION_X": reduction, "DECIMATION_Y": reduction,
            "FIELD_LEFT": max(0, left), "FIELD_TOP": max(0, top),
            "SENSOR_ADDRESS": plan.sensor.i2c_address}


def grid_offset(plan, crop):
    """Active pixels from a window's corner to where the even grid begins that capture makes of its
    samples: pixel k of the grid covers as many of them as the reduction is, from k times so many
    on."""
    return _offset(Way(plan.settings.skip, crop.binning), plan.settings.bins)


def _offset(way, bins):
    """As :func:`grid_offset`: the grid's middle is that of each pair of samples, which lie one
    active pixel apart."""
    centre = bins - 1 + (way.skip if way.binning else 0)        # of the first sample
    return centre + 1 - way.reduction


def _sent(sensor, geometry, way):
    """(width, height) of the frame that the sensor has to send."""
    step = max(2, sensor.limits.step)
    # One more for a corner of the other colour; whole pairs; those that an even grid drops.
    extra = _DROPPED if way.reduction > 1 else 0
    return [-(-(part + 1 + extra) // step) * step << way.binning for part in geometry.distorted]


def _corners(sensor, geometry, way, bins):
    """For each axis, first active pixels that the sensor's window can have, as a range: none if it
    does not fit."""
    found, step = [], max(2 * bins, sensor.limits.corner_step)
    for first, active, part in zip(sensor.first, (sensor.columns, sensor.rows),
                                   _sent(sensor, geometry, way)):
        # Unbinned, even pixels of the sensor are those of its first colour.
        begin = -first % step if bins > 1 else 0
        found.append(range(begin, active - way.skip * part + 1, step))
    return found


def _bins(sensor, geometry, way):
    """Numbers of columns whose mean a sample can be, the most first, with which a window fits."""
    pairs = ((1, 1), *sensor.limits.reductions)
    return [bins for bins in sorted((bins for skip, bins in pairs if skip == way.skip),
                                    reverse=True) if all(_corners(sensor, geometry, way, bins))]


def _fitting_ways(sensor, geometry, settings):
    """The :class:`Way` to each reduction with which raw frames fit the sensor; InputError if there
    is none. A sensor that mirrors does not skip."""
    mirrors = settings.get("mirror_columns") or settings.get("mirror_rows")
    ways = ways_of(sensor, 1 if mirrors else MAX_REDUCTION)
    fitting = {n: way for n, way in ways.items() if _bins(sensor, geometry, way)}
    if not fitting:
        size, sent = geometry.distorted, _sent(sensor, geometry, ways[1])
        raise InputError(f"raw frames of {size[0]}x{size[1]} take {sent[0]}x{sent[1]} pixels of a "
                         f"sensor, the {sensor.name} has {sensor.columns}x{sensor.rows}")
    return fitting


def _way_to(sensor, geometry, field, ways):
    """The :class:`Way` to reduce ``field`` to raw frames; InputError, with what fits, if none."""
    width, height = geometry.distorted
    sizes = {(n * width, n * height): way for n, way in ways.items()}
    if field.size not in sizes:
        fits = ", ".join(f"{x}x{y}" for x, y in sizes)
        raise InputError(
            f"the field is {field.size[0]}x{field.size[1]}, raw frames of {width}x{height} show "
            f"{fits} of the {sensor.name}'s {sensor.columns}x{sensor.rows} pixels")
    return sizes[field.size]


def _check_corner(sensor, field):
    """Raises :class:`InputError` unless the field lies on the sensor."""
    for name, begin, size, active in zip(("left", "top"), field.corner or (0, 0), field.size,
                                         (sensor.columns, sensor.rows)):
        if begin + size > active:
            raise InputError(f"{name} of the field is {begin}, one of {field.size[0]}x"
                             f"{field.size[1]} of the {sensor.name}'s {sensor.columns}x"
                             f"{sensor.rows} pixels has 0 to {active - size}")


def _smooth(found):
    """The first of pairs of a :class:`Setup` and more, in order of bins, whose frame rate is high
    enough."""
    rates = [plan.timing.frames_per_second for plan, _ in found]
    enough = min(_SMOOTH_HZ, max(rates))
    return next(one for one, rate in zip(found, rates) if rate >= enough)


def _positioned(sensor, geometry, way, bins, field, common):
    """Configuration and crop whose raw frame is nearest to ``field`` and has its colours."""
    width, height = _sent(sensor, geometry, way)
    active = sensor.columns, sensor.rows
    wanted = field.corner or [(all_ - part) / 2 for all_, part in zip(active, field.size)]
    for top, left in product((0, 1), (0, 1)):
        crop = Crop(left, top, grid_weight(way.reduction), way.binning)
        first = [min(corners, key=lambda one: abs(one + begin - goal)) for corners, begin, goal in (
            (corners, way.reduction * corner + _offset(way, bins), goal) for corners, corner, goal
            in zip(_corners(sensor, geometry, way, bins), crop, wanted))]
        plan = setup(sensor, Settings(width=width, height=height, left=first[0], top=first[1],
                                      skip=way.skip, bins=bins, **common))
        if geometry.bayer in (MONO, bayer_at(plan.bayer, left, top)):
            return plan, crop
    raise InputError(f"the frames are {geometry.bayer}, the {sensor.name} sends {plan.bayer}")
