"""Groups of neighbouring pixels that are processed together."""

from amaranth.lib import data

__all__ = ["grouped", "lanes_of"]


def grouped(fields, lanes):
    """``fields`` of each pixel of a group, and whether the group is the ``first`` or the ``last``
    of the frame.

    A group is ``lanes`` neighbouring pixels of a row, the leftmost one in lane 0. A single pixel
    has its fields next to the flags; more have them in an array ``lane``.
    """
    if lanes > 1:
        fields = {"lane": data.ArrayLayout(data.StructLayout(fields), lanes)}
    return data.StructLayout({**fields, "first": 1, "last": 1})


def lanes_of(group):
    """The pixels of a view of a :func:`grouped` layout, one view each, the leftmost first."""
    return list(group.lane) if "lane" in dict(group.shape()) else [group]
