"""Lenses of ``ncdc bench cost``: equidistant ones whose middle is shown pixel by pixel."""

import numpy as np

from ncdc_model.calibration.camera_file import training_grid
from ncdc_model.lens import Camera
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import Source
from ncdc_spec.geometry import Geometry
from ncdc_spec.interpolation import DEFAULT

__all__ = ["NEURONS", "trained_at"]

NEURONS = 12
_OPTIONS = {"starts": 16, "rounds": 1}


def trained_at(degrees, size):
    """The descriptor of an equidistant lens of ``degrees`` across, at nodes.

    Raw and corrected picture have ``size``, (width, height). The middle is neither enlarged nor
    reduced, so that a flat picture shows a part of a lens of 180 degrees, too.
    """
    width, height = size
    focal, middle = width / 2 / np.radians(degrees / 2), [(width - 1) / 2, (height - 1) / 2]
    camera = Camera.from_dict({
        "width": width, "height": height, "radial": "kb", "f_distorted": focal, "centre": middle,
        "f_corrected": focal, "corrected_size": list(size), "corrected_centre": middle})
    geometry = Geometry(*size, *size, interpolation=DEFAULT)
    source = Source(training_grid(camera.back_map, geometry), geometry, back_map=camera.back_map)
    choices = TrainingChoices(options=_OPTIONS, nodes="auto")
    return train_camera(source, NEURONS, choices).descriptor
