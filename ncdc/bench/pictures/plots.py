"""Pictures of ``ncdc bench pictures``: crops of every flow, enlarged, side by side."""

import cv2
import numpy as np
from matplotlib.figure import Figure

from ncdc_model.files import replace_file

__all__ = ["busiest", "plot_crops"]

_CROP = 64, 48          # columns and rows of a crop


def busiest(reference, size=_CROP):
    """(row, column) of the crop of ``reference`` (height, width, 3) with most fine detail."""
    width, height = size
    detail = np.abs(cv2.Laplacian(reference.astype(np.float32), cv2.CV_32F)).sum(axis=2)
    total = cv2.boxFilter(detail, -1, size, anchor=(0, 0), normalize=False)
    inside = total[:reference.shape[0] - height, :reference.shape[1] - width]
    return np.unravel_index(inside.argmax(), inside.shape)


def plot_crops(path, pictures, rows):
    """Write a JPEG: the same crop of each picture, four times as large, with its figures.

    Parameters
    ----------
    path : Path
    pictures : dict
        By flow, of which the first is the reference.
    rows : list of dict
        Of these flows, as of :func:`ncdc.bench.pictures.measure.measure`.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    top, left = busiest(pictures["reference"])
    figures = {row["flow"]: "{psnr_db:.1f} dB".format(**row) for row in rows}
    columns = min(3, len(pictures))
    lines = -(-len(pictures) // columns)
    figure = Figure(figsize=(4 * columns, 3.3 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, (flow, picture) in zip(panels, pictures.items()):
        axes.imshow(picture[top:top + _CROP[1], left:left + _CROP[0]], interpolation="nearest")
        axes.set_title(", ".join(filter(None, (flow, figures.get(flow)))), fontsize=9)
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=80, format="jpeg", pil_kwargs={"quality": 85})
