"""Reads the raw frame of camera RAW files by LibRaw, never their preview."""

from io import BytesIO

import numpy as np

from ncdc_model.photo.photo import Photo
from ncdc_model.photo.quiet import captured_stderr
from ncdc_model.samples import scaled
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE, MONO

__all__ = ["UnknownRaw", "read_camera_raw"]


class UnknownRaw(InputError):
    """A file that LibRaw does not support."""


def read_camera_raw(path, content, bits, warn):
    """The :class:`Photo` with the raw frame in ``content`` of the camera RAW file ``path``.

    The frame is the active area, without the sensor's masked margins. The black level of each
    colour is subtracted, and the range up to the white level is scaled to eight bits. The
    orientation of the camera is ignored.

    Raises
    ------
    InputError
        If the filter pattern is not Bayer's, the file holds no raw frame, or ``bits`` differs from
        its declaration.
    UnknownRaw
        If LibRaw does not support the file.
    """
    import rawpy  # takes 0.1 s
    try:
        with captured_stderr(), rawpy.imread(BytesIO(content)) as raw:
            photo, sentence = _frame(path, raw, bits)
    except rawpy.LibRawError as error:
        reason = error.args[0].decode() if isinstance(error.args[0], bytes) else error
        raise UnknownRaw(f"{path} is a camera RAW file that LibRaw cannot read ({reason}); save "
                         f"its raw frame as a 16-bit PNG") from error
    warn(sentence)
    return photo


def _frame(path, raw, bits):
    """The photo of an opened file, and a sentence on how it was read."""
    if raw.raw_type.name != "Flat":
        raise InputError(f"{path} is a camera RAW file without a raw frame: its pixels have "
                         f"several colours each (linear RAW); save it as a TIFF")
    samples, colours = raw.raw_image_visible, raw.raw_colors_visible
    white = int(raw.white_level)
    if bits not in (None, white.bit_length()):
        raise InputError(f"{path} declares samples of {white.bit_length()} bits (0 to {white}), "
                         f"--bits says {bits}")
    height, width = samples.shape
    if raw.num_colors == 1:
        bayer, tile = MONO, np.zeros((2, 2), int)
    else:
        tile = colours[:2, :2]
        bayer = "".join(raw.color_desc.decode()[k] for k in tile.ravel())
        whole = np.tile(tile, (height // 2 + 1, width // 2 + 1))[:height, :width]
        if bayer not in BAYER_PHASE or not np.array_equal(colours, whole):
            raise InputError(f"{path} has a filter pattern that is not Bayer's, as Fujifilm's "
                             f"X-Trans, which is not supported")
    black = np.array(raw.black_level_per_channel)[tile]
    if white <= black.max():
        raise InputError(f"{path} declares the black level {black.max()} and the white level "
                         f"{white}: that leaves no light")
    image = np.empty(samples.shape, np.uint8)
    for row, column in np.ndindex(2, 2):
        level = samples.dtype.type(black[row, column])
        part = samples[row::2, column::2]
        image[row::2, column::2] = scaled(np.maximum(part, level) - level, white - int(level))
    sizes = raw.sizes
    levels = "/".join(str(level) for level in dict.fromkeys(black.ravel().tolist()))
    return Photo(image, bayer), (
        f"{path} is a camera RAW file: its {bayer} frame of {width}x{height} pixels is taken, "
        f"from column {sizes.left_margin}, row {sizes.top_margin} of {sizes.raw_width}x"
        f"{sizes.raw_height}, black level {levels}, white {white}")
