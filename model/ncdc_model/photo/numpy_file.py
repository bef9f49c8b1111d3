"""Reads arrays in NumPy's .npy files: one frame or several."""

from io import BytesIO

import numpy as np

from ncdc_model.photo.photo import Photo
from ncdc_model.samples import eight_bits
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MIN_SIZE

__all__ = ["read_npy"]

_SHAPES = "(height, width), (frames, height, width), (height, width, 3) or (frames, height, " \
          "width, 3)"


def read_npy(path, content, bits, warn):
    """The :class:`Photo` in ``content`` of the .npy file ``path``; the first of several frames.

    Raises
    ------
    InputError
        If it is damaged, or no uint8 or uint16 array of the shape of one or several frames.
    """
    try:
        samples = np.load(BytesIO(content), allow_pickle=False)
    except Exception as error:      # also from Python's tokenizer, which reads the header
        reason = str(error).splitlines()[:1] or [type(error).__name__]
        raise InputError(f"{path} is a NumPy file that cannot be read: {reason[0]}") from error
    if samples.dtype.kind != "u" or samples.dtype.itemsize > 2:
        raise InputError(f"{path} holds {samples.dtype} samples, 8 or 16 bit unsigned integers are "
                         f"needed")
    shape = samples.shape
    if samples.ndim > 2 and shape[-1] == 1:
        samples = samples[..., 0]
    colour = samples.ndim > 2 and samples.shape[-1] == 3
    sides = samples.shape[-3:-1] if colour else samples.shape[-2:]
    if (samples.ndim not in ((3, 4) if colour else (2, 3)) or min(sides) < MIN_SIZE
            or not samples.size):
        raise InputError(f"{path} holds an array of the shape {shape}, {_SHAPES} with sides of at "
                         f"least {MIN_SIZE} is needed")
    if samples.ndim == (4 if colour else 3):
        if len(samples) > 1:
            warn(f"{path}: the first of {len(samples)} frames is taken")
        samples = samples[0]
    if colour:
        warn(f"{path} has three channels: taken as R, G, B")
    samples = np.ascontiguousarray(samples)
    image = eight_bits(samples, 255 if samples.dtype == np.uint8 else None, bits, path, warn)
    return Photo(image)
