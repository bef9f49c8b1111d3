"""Where the views of a device look, and how they share its picture."""

from ncdc_spec.errors import InputError
from ncdc_spec.protocols.features import VIEW_FEATURES, feature
from ncdc_spec.view_layout import LAYOUTS, MAX_SHOWN, areas
from ncdc_spec.view_matrix import Angles, PlaneCamera, has_plane

__all__ = ["Views"]

_ANGLES = {one.name.upper(): one for one in VIEW_FEATURES if one.access == "rw"}
_LIMITS = {"VIEW_LAYOUT": len(LAYOUTS), "VIEW_SELECTED": MAX_SHOWN}


def _angles_of(numbers):
    """The :class:`Angles` of numbers in words of Table I, by name."""
    return Angles(**{name.lower(): number / _ANGLES[name].scale[1]
                     for name, number in numbers.items()})


class Views:
    """The words PAN to VIEW_SELECTED of Table I, of a device with or without a view.

    Parameters
    ----------
    planes : sequence of PlaneCamera
        Camera of each lens's corrected picture; empty: there is no view.
    size : (int, int)
        Of the corrected picture.
    """
    def __init__(self, planes, size):
        self._planes = list(planes)     # None of a lens that does not state it
        self._size = size
        # Numbers of the angles of each view.
        self._looks = [{name: round(getattr(Angles(), name.lower()) * one.scale[1])
                        for name, one in _ANGLES.items()}] * MAX_SHOWN
        self._choices = dict.fromkeys(_LIMITS, 0)

    def __bool__(self):
        return bool(self._planes)

    @property
    def layout(self):
        """The one of :data:`~ncdc_spec.view_layout.LAYOUTS` that is chosen."""
        return LAYOUTS[self._choices["VIEW_LAYOUT"]]

    @property
    def looks(self):
        """The :class:`Angles` of each view that is shown."""
        return tuple(_angles_of(numbers)
                     for numbers, _ in zip(self._looks, areas(self.layout, self._size)))

    def focal(self, lens):
        """The number in ViewFocal's register; 0 if the ``lens`` of that number has no camera."""
        plane = self._planes[lens] if self else None
        return round(feature("ViewFocal").scale[1] * plane.focal) if plane else 0

    def words(self):
        """Values of the words by name; none without a view."""
        if not self:
            return {}
        selected = self._looks[self._choices["VIEW_SELECTED"]]
        return {name: number & 0xFFFF for name, number in selected.items()} | self._choices

    def write(self, name, word):
        """Change a word; raises :class:`InputError` if a lens cannot look so far off its axis, or
        the word is beyond its limits."""
        looks, choices = list(self._looks), dict(self._choices)
        if name in _ANGLES:
            number = _ANGLES[name].register(lambda _: word)
            selected = choices["VIEW_SELECTED"]
            looks[selected] = looks[selected] | {name: number}
            _angles_of(looks[selected])         # one that is not shown has limits, too
        elif word >= _LIMITS[name]:
            raise InputError(f"{name} is {word}, the limits are 0 and {_LIMITS[name] - 1}")
        else:
            choices[name] = word
        _check(self._planes, looks, areas(LAYOUTS[choices["VIEW_LAYOUT"]], self._size))
        self._looks, self._choices = looks, choices

    def replace_lens(self, number, descriptor):
        """Take the camera of a lens's picture from another ``descriptor``.

        A lens that does not state it is shown as trained.

        Raises
        ------
        InputError
            If it cannot look as far off its axis as the device does.
        """
        if self:
            plane = PlaneCamera.of(descriptor) if has_plane(descriptor) else None
            _check([plane], self._looks, areas(self.layout, self._size))
            self._planes[number] = plane


def _check(planes, looks, parts):
    """Raise :class:`InputError` unless lenses of these ``planes`` can look there."""
    for numbers, area in zip(map(_angles_of, looks), parts):
        for plane in filter(None, planes):
            plane.looking(numbers, area.size)
