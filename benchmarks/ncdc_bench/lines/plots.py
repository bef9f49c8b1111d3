"""Pictures of ``ncdc bench lines``: the photo of the board and its corrections, side by side."""

import numpy as np
from matplotlib.figure import Figure

from ncdc_spec.files import replace_file

__all__ = ["plot_lines"]

_FOUND, _MISSED = "#00b050", "#e02020"


def plot_lines(path, raw, results):
    """Write a JPEG: photo ``raw``, then each correction with its lines, found green, missed red.

    Parameters
    ----------
    path : Path
    raw : ndarray
        Raw frame.
    results : list of (str, ndarray, list of Line)
        Title, corrected picture, lines.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    height, width = raw.shape
    columns = 2
    rows = -(-(1 + len(results)) // columns)
    figure = Figure(figsize=(6 * columns, rows * (6 * height / width + .3)), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    panels[0].imshow(_grey(raw), cmap="gray", vmin=0, vmax=255)
    panels[0].set_title("photo", fontsize=10)
    for axes, (title, picture, lines) in zip(panels[1:], results):
        axes.imshow(picture)
        for line in lines:
            axes.plot(*line.ends.T, color=_MISSED if line.missed else _FOUND,
                      linewidth=2.2 if line.missed else 1.0)
        axes.set(xlim=(-.5, picture.shape[1] - .5), ylim=(picture.shape[0] - .5, -.5))
        axes.set_title(title, fontsize=10)
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=75, format="jpeg", pil_kwargs={"quality": 70})


def _grey(raw):
    """Mean of each 2x2 samples: the colour filter's pattern would show."""
    return np.mean([raw[j::2, i::2] for j in range(2) for i in range(2)], axis=0)
