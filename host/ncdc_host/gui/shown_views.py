"""Where the views of a device are in the picture that it sends."""

from PySide6.QtCore import QPointF, QRectF

from ncdc_spec.view_layout import LAYOUTS, areas

__all__ = ["LAYOUT", "SELECTOR", "ShownViews"]

LAYOUT, SELECTOR = "ViewLayout", "ViewSelector"     # features of a device with several views


class ShownViews:
    """The views of a device with the features ``infos``, a dict of :class:`FeatureInfo`.

    Attributes
    ----------
    areas : list of Area
        Of the views, in the whole picture, not mirrored.
    selected : int
        Number of the view that Pan, Tilt, Roll and Zoom are of.
    """

    def __init__(self, infos):
        self._infos = infos
        self._whole = infos["WidthMax"].value, infos["HeightMax"].value
        several = LAYOUT in infos
        self.areas = areas(infos[LAYOUT].value if several else LAYOUTS[0], self._whole)
        self.selected = infos[SELECTOR].choices.index(infos[SELECTOR].value) if several else 0

    def share(self, number):
        """Width of a view, as a share of the whole picture's."""
        return self.areas[min(number, len(self.areas) - 1)].size[0] / self._whole[0]

    def mirrored(self, name):
        """Whether a direction is mirrored; a sensor may have no such mirror."""
        return name in self._infos and self._infos[name].value

    def under(self, point):
        """Number of the view that is shown at a point of the picture, a QPointF; the selected one
        if there is none."""
        where = self._moved(QPointF(point))
        return next((k for k, area in reversed(list(enumerate(self.areas)))
                     if area.holds(where.x(), where.y())), self.selected)

    def rect(self, number):
        """The part of the picture that shows a view, a QRectF; None if it is not shown."""
        if number >= len(self.areas):
            return None
        area = self.areas[number]
        corner = QPointF(area.x, area.y)
        ends = [self._moved(one, -1) for one in (corner, corner + QPointF(*area.size))]
        return QRectF(*ends).normalized()

    def _moved(self, point, sign=1):
        """A point of the picture in the whole picture that is not mirrored; with the sign -1, from
        there to the picture."""
        moved = []
        for value, whole, offset, mirror in zip(
                (point.x(), point.y()), self._whole, ("OffsetX", "OffsetY"),
                ("ReverseX", "ReverseY")):
            start = self._infos[offset].value
            value += start if sign > 0 else 0
            value = whole - value if self.mirrored(mirror) else value
            moved.append(value - (start if sign < 0 else 0))
        return QPointF(*moved)
