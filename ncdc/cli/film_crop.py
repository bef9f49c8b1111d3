"""A film that shows a part of the picture its lens was measured in, with other pixels."""

from dataclasses import dataclass

import numpy as np

from ncdc.terminal import say
from ncdc_model.view_map import view_map
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.field import field_named

__all__ = ["FilmCrop", "add_film_crop", "film_crop"]

_SQUARE = 0.02          # by which the pixels of a film may differ from their stated shape


def add_film_crop(parser):
    """Declare the option --film-crop."""
    parser.add_argument("--film-crop", metavar="CROP",
                        help="part of the picture that the lens was measured in which the film "
                             "shows, in pixels of that picture: WIDTHxHEIGHT around its middle, "
                             "WIDTHxHEIGHT+LEFT+TOP, or full, as much as has the film's shape")


@dataclass(frozen=True)
class FilmCrop:
    """Which part of the raw frame of a lens a film shows.

    Parameters
    ----------
    corner, part : (float, float), (int, int)
        Left and top, width and height, in pixels of the raw frame.
    film : (int, int)
        Width and height in pixels of the film.
    """
    corner: tuple
    part: tuple
    film: tuple

    @property
    def scale(self):
        """Pixels of the film for one of the raw frame, along a row and along a column."""
        return tuple(film / part for film, part in zip(self.film, self.part))

    def size(self, geometry):
        """Width and height of the corrected film, which shows the same part of the corrected
        picture as the film of the raw frame."""
        return tuple(max(1, round(scale * part * whole / raw)) for scale, part, whole, raw in zip(
            self.scale, self.part, geometry.corrected, geometry.distorted))

    def maps(self, descriptor):
        """The maps of :meth:`of_film` of the corrected film."""
        geometry = descriptor.geometry
        matrix = np.eye(3)
        for axis, (corner, part, whole, raw, size) in enumerate(zip(
                self.corner, self.part, geometry.corrected, geometry.distorted,
                self.size(geometry))):
            step = part * whole / raw / size
            matrix[axis, axis], matrix[axis, 2] = step, corner * whole / raw + (step - 1) / 2
        return self.of_film(*view_map(descriptor, self.size(geometry), matrix))

    def of_film(self, map_x, map_y, blank):
        """Source pixels in the film, and pixels without one, of those in the raw frame."""
        made, inside = [], ~blank
        for source, corner, scale, size in zip((map_x, map_y), self.corner, self.scale, self.film):
            made.append(((source + .5 - corner) * scale - .5).astype(np.float32))
            inside &= (made[-1] >= -1) & (made[-1] <= size)
        return *made, ~inside


def film_crop(args, name, film, aspect, geometry):
    """The :class:`FilmCrop` of a film ``name``, or None if its pixels are those of the raw frame.

    Parameters
    ----------
    args : argparse.Namespace
    name : str
    film : (int, int)
        Width and height in pixels.
    aspect : Fraction
        Width of its pixels over their height.
    geometry : Geometry

    Raises
    ------
    InputError
        If sizes differ and --film-crop does not say how, or what it says does not fit.
    """
    whole = geometry.distorted
    fitting = _fitting(film, aspect, whole)
    if args.film_crop is None:
        if film == whole:
            return None
        raise InputError("{} has {}x{} pixels, the descriptor is for {}x{}: measure the lens in "
                         "the film, ncdc calibrate --live {}, or say which part of the {}x{} it "
                         "shows, as --film-crop {}x{}".format(name, *film, *whole, name, *whole,
                                                              *fitting))
    field = field_named(args.film_crop)
    part = field.size or fitting
    corner = field.corner or tuple((one - two) / 2 for one, two in zip(whole, part))
    if not all(low >= 0 and size >= 1 and low + size <= one
               for low, size, one in zip(corner, part, whole)):
        raise InputError("--film-crop is {}, which is not within the {}x{} pixels of the "
                         "descriptor".format(args.film_crop, *whole))
    crop = FilmCrop(corner, part, film)
    shape = crop.scale[1] / crop.scale[0]
    if abs(shape / aspect - 1) > _SQUARE:
        raise InputError(f"--film-crop is {args.film_crop}, by which the pixels of {name} are "
                         f"{shape:.3f} times as wide as high, it says {float(aspect):.3f}: "
                         f"{fitting[0]}x{fitting[1]} has its shape")
    say("{}: its {}x{} pixels are {}x{} of the descriptor's {}x{}, from column {:g} and row {:g}, "
        "at {:.3f} to one".format(name, *film, *part, *whole, *corner, crop.scale[0]))
    return crop


def _fitting(film, aspect, whole):
    """Width and height of the largest part of ``whole`` that has a film's shape."""
    shape = film[0] * aspect / film[1]
    if shape * whole[1] >= whole[0]:
        return whole[0], round(whole[0] / shape)
    return round(whole[1] * shape), whole[1]
