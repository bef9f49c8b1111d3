"""Reference model of a list of views: the bytes of the buffer that they share."""

import numpy as np

from ncdc_model.golden.corrector import correct
from ncdc_spec.frames import stored_bytes

__all__ = ["compose"]


def compose(descriptor, raw, entries, buffer=None, corrected=correct, **options):
    """Correct the ``raw`` frame once for each of ``entries``; bytes of the buffer, uint8 (bytes,).

    Later views cover earlier ones.

    Parameters
    ----------
    descriptor : Descriptor
    raw : ndarray of uint8, shape (distorted height, distorted width)
    entries : sequence of Entry
    buffer : ndarray of uint8, optional
        Content before, which is changed; zeros, as many as the views need, if absent.
    corrected : callable
        :func:`ncdc_model.golden.corrector.correct`, or :func:`ncdc_model.correction.correct`, which
        is compiled.
    options :
        As of ``corrected``.
    """
    if buffer is None:
        buffer = np.zeros(max(entry.end for entry in entries), np.uint8)
    for entry in entries:
        picture = corrected(descriptor, raw, view=entry.view, **options).picture
        for v, row in enumerate(stored_bytes(picture, entry.form)):
            first = entry.offset + v * entry.stride
            buffer[first:first + entry.row_bytes] = row.ravel()
    return buffer
