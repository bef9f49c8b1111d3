"""The option of the part of a sensor that raw frames show, and what it makes of the sensor."""

from ncdc_spec.sensors.field import FULL
from ncdc_spec.sensors.framing import Crop, shown

__all__ = ["add_field", "field_lines", "field_of", "field_report"]


def add_field(parser):
    """Declare the option --field."""
    parser.add_argument("--field", metavar="FIELD",
                        help="part of the sensor that raw frames show, reduced to their size: "
                             "full (default: the largest one that fits), WIDTHxHEIGHT around the "
                             "middle, or WIDTHxHEIGHT+LEFT+TOP, in pixels of the sensor")


def field_of(args):
    """The field that is asked for, by default the whole one."""
    return FULL if args.field is None else args.field


def field_report(plan, crop, geometry):
    """The figures under their names in every report."""
    left, top, width, height = _clipped(plan, crop, geometry)
    asked, sensor = plan.settings, plan.sensor
    return {"field": {"left": left, "top": top, "width": width, "height": height,
                      "sensor_width": sensor.columns, "sensor_height": sensor.rows,
                      "reduction": asked.skip << Crop(*crop).binning, "sensor_skip": asked.skip,
                      "sensor_bins": asked.bins, "fpga_binning": 1 + Crop(*crop).binning}}


def field_lines(plan, crop, geometry):
    """Lines for people: the part of the sensor, how it is reduced, and what the photos of the
    calibration target must show. None for a test pattern, which is no part of a sensor."""
    if not plan.writes:
        return ()
    left, top, width, height = _clipped(plan, crop, geometry)
    sensor, size = plan.sensor, f"{geometry.distorted_width}x{geometry.distorted_height}"
    wide, high = (f"{100 * part / of:.0f} %" for part, of in
                  ((width, sensor.columns), (height, sensor.rows)))
    sides = f"{wide} of each side" if wide == high else f"{wide} of the width, {high} of the height"
    whole = f"{sensor.columns}x{sensor.rows}"
    return (
        f"raw frames show {width}x{height}+{left}+{top} of the {sensor.name}'s {whole} pixels, "
        f"{sides}; {_how(plan, crop)}",
        f"photos for ncdc calibrate must show the same: of the sensor's whole picture these "
        f"{width}x{height} pixels, reduced to {size}" if width > geometry.distorted_width else
        f"photos for ncdc calibrate must show the same: of the sensor's whole picture these "
        f"{size} pixels")


def _clipped(plan, crop, geometry):
    """The field of :func:`shown`, without pixels of an even grid outside of the sensor."""
    left, top, width, height = shown(plan, Crop(*crop), geometry)
    return max(0, left), max(0, top), width, height


def _how(plan, crop):
    """A text on the steps of the reduction."""
    asked, binning = plan.settings, Crop(*crop).binning
    if asked.skip == 1 and not binning:
        return "every pixel is read"
    steps = [f"the sensor skips by {asked.skip}" + f" and bins {asked.bins}" * (asked.bins > 1)
             ] * (asked.skip > 1) + ["the FPGA bins 2"] * binning
    return f"reduced by {asked.skip << binning}: {', '.join(steps)}"
