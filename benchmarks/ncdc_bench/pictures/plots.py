"""Pictures of ``ncdc bench pictures``: before and after, and crops of every flow, enlarged."""

import cv2
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from ncdc_spec.files import replace_file
from ncdc_spec.interpolation import DEFAULT

__all__ = ["busiest", "plot_crops"]

_CROP = 64, 48          # columns and rows of a crop


def busiest(reference, size=_CROP):
    """(row, column) of the crop of ``reference`` (height, width, 3) with the most fine detail."""
    width, height = size
    detail = np.abs(cv2.Laplacian(reference.astype(np.float32), cv2.CV_32F)).sum(axis=2)
    total = cv2.boxFilter(detail, -1, size, anchor=(0, 0), normalize=False)
    inside = total[:reference.shape[0] - height, :reference.shape[1] - width]
    return np.unravel_index(inside.argmax(), inside.shape)


def plot_crops(path, before, pictures, rows):
    """Write a JPEG: a picture before and after, and the same crop of each flow, enlarged.

    Parameters
    ----------
    path : Path
    before : ndarray
        The picture, (height, width, 3) uint8, as the camera sees it.
    pictures : dict
        By flow; among them ``reference``, whose detail chooses the crop, and the default
        interpolation, whose whole picture is shown.
    rows : list of dict
        Rows of these flows, from :func:`ncdc_bench.pictures.measure.measure`.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    top, left = busiest(pictures["reference"])
    figures = {row["flow"]: "{psnr_db:.1f} dB".format(**row) for row in rows}
    columns = -(-len(pictures) // 2)
    figure = Figure(figsize=(4 * (1 + columns), 6.6), layout="constrained")
    panels = figure.subplots(2, 1 + columns)
    for axes, title, picture in zip(panels[:, 0], ("as the camera sees it",
                                                   f"corrected, {DEFAULT.name}"),
                                    (before, pictures[DEFAULT.name])):
        axes.imshow(picture)
        axes.set_title(title, fontsize=13)
    panels[1, 0].add_patch(Rectangle((left - .5, top - .5), *_CROP, fill=False, color="red",
                                     linewidth=2))
    for axes, (flow, picture) in zip(panels[:, 1:].ravel(), pictures.items()):
        axes.imshow(picture[top:top + _CROP[1], left:left + _CROP[0]], interpolation="nearest")
        axes.set_title(", ".join(filter(None, (flow, figures.get(flow)))), fontsize=13)
    for axes in panels.ravel():
        axes.set_axis_off()
    with replace_file(path) as temporary:
        figure.savefig(temporary, dpi=75, format="jpeg", pil_kwargs={"quality": 85})
