"""What several commands share: the raw frame of an image, reports."""

import json
import math

from ncdc_model.files import write_stream
from ncdc_model.images import is_raw, mosaic, read_image

__all__ = ["add_camera", "add_json", "raw_frame", "straightness_text", "write_report"]


_RELIEF = 0.005        # px rms: less would be told as a relief of 0.00 px


def raw_frame(path, geometry):
    """The raw Bayer frame of the image file ``path``, and a note if it had to be made.

    A picture of one channel is taken for the raw frame itself; of a colour picture, each pixel
    keeps the colour that the filter would have passed.
    """
    image = read_image(path)
    if is_raw(image):
        return image, None
    note = f"{path} is a colour picture: mosaiced as {geometry.bayer}"
    return mosaic(image, geometry.bayer), note


def straightness_text(report, points):
    """One or two lines on the straightness of a target's rows and columns on ``points``."""
    text = f"rows and columns straight to {report['straightness_rms_px']:.3f} px rms on {points}"
    if math.isfinite(report["straightness_floor_rms_px"]):
        text += f", their own scatter is worth {report['straightness_floor_rms_px']:.3f}"
    if report["relief_rms_px"] >= _RELIEF:
        text += (f"\nthe target is not flat: its relief, {report['relief_rms_px']:.2f} px rms, is "
                 f"taken off; taken as flat: {report['straightness_as_flat_rms_px']:.3f} px rms")
    return text


def add_camera(parser):
    """Declare the option --camera."""
    parser.add_argument("--camera", metavar="NAME",
                        help="which camera of a Kalibr camchain, as in cam1")


def add_json(parser):
    """Declare the option --json."""
    parser.add_argument("--json", metavar="FILE", help="write the report as JSON; - for stdout")


def write_report(report, target):
    """Write ``report`` as JSON to the file ``target``; "-": to stdout, and return True."""
    text = json.dumps(_finite(report), indent=2) + "\n"
    if target == "-":
        print(text, end="")
        return True
    if target:
        write_stream(target, text)
    return False


def _finite(value):
    """``value`` with numbers that JSON does not know as null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
