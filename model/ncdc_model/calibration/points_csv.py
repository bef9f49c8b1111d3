"""Points as comma-separated values, for other calibration software."""

import numpy as np

from ncdc_model.files import write_text

__all__ = ["STYLES", "points_csv", "save_csv"]

_CORRESPONDENCES = "photo,object_x,object_y,object_z,image_x,image_y"
_LINES = "photo,direction,line,y,x"


def points_csv(points, style):
    """Text of the :class:`TargetPoints` in one of :data:`STYLES`.

    opencv : object point (column, row, 0), in steps of the target, and image point, as
        ``cv2.calibrateCamera`` takes them.
    discorpy : the points line by line as Discorpy groups them: horizontal lines from the top,
        each from the left, then vertical lines from the left, each from the top; y before x.
    """
    header, rows = STYLES[style]
    lines = [",".join(map(str, row)) for photo in points.photos
             for row in rows(photo.whole)]
    return "\n".join([header, *lines]) + "\n"


def save_csv(path, points, style):
    """Write :func:`points_csv`; the file is replaced whole or not at all."""
    write_text(path, points_csv(points, style))


def _correspondences(photo):
    for (column, row), (x, y) in zip(photo.index, photo.xy):
        yield _quoted(photo.name), column, row, 0, f"{x:.4f}", f"{y:.4f}"


def _lines(photo):
    for direction, along, across in (("horizontal", 0, 1), ("vertical", 1, 0)):
        order = np.lexsort((photo.index[:, along], photo.index[:, across]))
        for k in order:
            x, y = photo.xy[k]
            yield (_quoted(photo.name), direction, photo.index[k, across], f"{y:.4f}", f"{x:.4f}")


def _quoted(name):
    """``name`` as one field."""
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',"\n') else name


STYLES = {"opencv": (_CORRESPONDENCES, _correspondences), "discorpy": (_LINES, _lines)}
