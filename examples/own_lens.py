"""A camera model of your own: from its equation to a descriptor.

    python examples/own_lens.py [net.toml [WxH]]

The model is Fitzgibbon's division model, which the package does not have: the ideal radius is
r / (1 + strength r^2) of the distorted radius r. A network needs one function of a lens: the
back-map, from a pixel (u, v) of the corrected picture to its source (x, y) in the photo.
"""

import sys
from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.camera_file import training_grid
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import Source
from ncdc_spec.geometry import Geometry


@dataclass(frozen=True)
class DivisionLens:
    """Division model of a barrel distortion, in pixels from the picture's middle.

    Parameters
    ----------
    strength : float
        Of the distortion, negative for a barrel, in 1/px^2.
    zoom : float
        Corrected pixels per distorted pixel in the middle.
    geometry : Geometry
    """
    strength: float
    zoom: float
    geometry: Geometry

    def back_map(self, u, v):
        """Source (x, y) of the corrected pixels (u, v), arrays of one shape."""
        width, height = self.geometry.corrected
        a = (np.asarray(u, float) - (width - 1) / 2) / self.zoom
        b = (np.asarray(v, float) - (height - 1) / 2) / self.zoom
        ideal = np.hypot(a, b)
        # ideal = r / (1 + strength r^2), solved for r; its ratio to ideal is finite in the middle.
        ratio = 2 / (1 + np.sqrt(1 - 4 * self.strength * ideal**2))
        width, height = self.geometry.distorted
        return a * ratio + (width - 1) / 2, b * ratio + (height - 1) / 2


def main(output="own_lens.toml", size="320x240", neurons=6):
    """Train a network on the lens and write its descriptor; return the report."""
    width, height = map(int, size.split("x"))
    geometry = Geometry(width, height, width, height)
    lens = DivisionLens(strength=-4e-6 * (640 / width)**2, zoom=1.0, geometry=geometry)
    source = Source(training_grid(lens.back_map, geometry), geometry, lens.back_map,
                    provenance={"source": "examples/own_lens.py", "source_kind": "own lens"})
    trained = train_camera(source, neurons, TrainingChoices(seed=1))
    trained.descriptor.save(output)
    error = trained.report["map_error_fixed_px"]
    print(f"{output}: {neurons} hidden neurons, error of the map in fixed point "
          f"{error['mean']:.3f} px on average, {error['max']:.3f} px at most")
    return trained.report


if __name__ == "__main__":
    main(*sys.argv[1:3])
