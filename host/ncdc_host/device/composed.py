"""Several views of one raw frame in one picture."""

import numpy as np

from ncdc_model.golden.corrector import Corrected

__all__ = ["ComposedCorrection"]


class ComposedCorrection:
    """Corrects raw frames into several views, each in its area of one picture.

    Parameters
    ----------
    descriptor : Descriptor
    views : list of Correction
    areas : list of Area
        Of the views, of their sizes; later ones cover earlier ones.
    """
    def __init__(self, descriptor, views, areas):
        self.descriptor, self._views, self._areas = descriptor, views, areas

    def __call__(self, raw, crest=0):
        """The :class:`~ncdc_model.golden.corrector.Corrected` frame of a ``raw`` one."""
        geometry = self.descriptor.geometry
        shape = geometry.corrected[::-1]
        picture = np.full((*shape, 3), geometry.fill, np.uint8)
        blank, fetches = np.ones(shape, bool), 0
        for view, area in zip(self._views, self._areas):
            part = view(raw, crest)
            width, height = area.size
            at = np.s_[area.y:area.y + height, area.x:area.x + width]
            picture[at], blank[at] = part.picture, part.blank
            fetches += part.fetches
        return Corrected(picture, blank, fetches)
