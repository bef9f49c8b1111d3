"""Common parts of several commands: the raw frame of an image, reports."""

import json
import math
import sys

from ncdc.terminal import say
from ncdc_model.images import is_raw, mosaic
from ncdc_model.photo import read
from ncdc_model.photo.photo import Photo
from ncdc_model.raw_dump import RawDump
from ncdc_model.samples import check_bits
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_stream
from ncdc_spec.geometry import MONO

__all__ = ["add_camera", "add_json", "add_page", "add_samples", "raw_frame", "read_photo",
           "report_failures", "straightness_text", "write_report"]


_RELIEF = 0.005        # px rms: less would be printed as 0.00 px


def add_page(parser):
    """Declare the options --flat and --relief."""
    page = parser.add_mutually_exclusive_group()
    page.add_argument("--flat", dest="page", action="store_const", const="flat",
                      help="the target is flat: what no smooth lens explains is the lens's own")
    page.add_argument("--relief", dest="page", action="store_const", const="relief",
                      help="the target is wavy or dented: what moves its points along its normal "
                           "only is taken off (default: only if several photos prove it)")


def add_samples(parser):
    """Declare the options --bits and --raw."""
    parser.add_argument("--bits", type=int, metavar="N",
                        help="bits of a sample, 8 to 16, of files that only say 16 (default: the "
                             "smallest usual number that holds the brightest sample)")
    parser.add_argument("--raw", metavar="WxH:PATTERN:BITS[p][:stride=N][:frame=K]",
                        help="the file is a dump of bare samples, as in 1280x1024:RGGB:12: bytes, "
                             "or from 9 bits on two bytes each, lower first; 10p, 12p, 14p: packed "
                             "as MIPI does; stride: bytes a row; frame: which one, from 1")


def read_photo(path, raw=None, bits=None, warn=say):
    """Read the :class:`ncdc_model.photo.photo.Photo` in the file ``path``.

Parameters
    ----------
    path : str
    raw : str, optional
        The option --raw: how a file of bare samples is laid out.
    bits : int, optional
        The option --bits: bits of a sample.
    warn : callable
        Called with a sentence if a property is guessed, or only a part of the file is read.

    Raises
    ------
    InputError
        If an option is bad or does not suit the file.
    """
    if raw is not None:
        if bits is not None:
            raise InputError("--bits and --raw are given, --raw says the bits itself")
        dump = RawDump.parse(raw)
        return Photo(dump.read(path, warn), dump.bayer)
    if bits is not None:
        check_bits(bits)
    return read.read_photo(path, bits, warn)


def raw_frame(path, geometry, raw=None, bits=None):
    """The raw Bayer frame of the file ``path``, and a note on how its samples were interpreted.

    ``raw`` and ``bits`` are those of :func:`read_photo`.

    A picture of one channel is the raw frame itself. A colour picture is mosaiced: each pixel
    keeps the colour that the filter would have passed. A grey JPEG is rejected, as it cannot be the
    raw frame of a colour sensor. A grey sensor accepts any grey picture, and the brightness of a
    colour picture.

    Raises
    ------
    InputError
        If the file cannot be read, or its filter pattern is not that of ``geometry``.
    """
    photo = read_photo(path, raw, bits)
    image = photo.image
    if photo.bayer is not None:
        if photo.bayer != geometry.bayer:
            raise InputError(f"the raw frame has the pattern {photo.bayer}, the descriptor "
                             f"{geometry.bayer}")
        return image, None
    if geometry.mono:
        return ((image, f"{path} has one channel: taken as the grey frame") if is_raw(image) else
                (mosaic(image, MONO), f"{path} is a colour picture: its brightness is taken"))
    if is_raw(image):
        if photo.lossy:
            raise InputError(f"{path} is a grey JPEG, a raw {geometry.bayer} frame or a colour "
                             f"picture is needed; a grey camera is trained with --bayer {MONO}")
        return image, f"{path} has one channel: taken as the raw {geometry.bayer} frame"
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
                        help="which of several cameras or maps in a file: cam1 of a Kalibr "
                             "camchain, the id in COLMAP's cameras, left of a stereo pair")


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


def report_failures(command, sentences):
    """Print a line on stderr for each of ``sentences``; the exit status: 1 if there is one."""
    for sentence in sentences:
        print(f"ncdc {command}: {sentence}", file=sys.stderr)
    return int(bool(sentences))


def _finite(value):
    """``value`` with numbers that JSON does not know as null."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
