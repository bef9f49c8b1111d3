"""Cameras of the benches: ideal wide-angle lenses with flaws, turned about their axis."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from ncdc_bench.sources import source_digest
from ncdc_model.calibration.camera_file import training_grid
from ncdc_model.lens import Camera
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.pipeline import train_camera
from ncdc_model.training.source import Source
from ncdc_spec.builds import built, key_of
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.geometry import Geometry
from ncdc_spec.interpolation import FAST, interpolation_of

__all__ = ["NEURONS", "Lens", "trained"]

NEURONS = 8
_OPTIONS = {"starts": 16, "rounds": 1}


@dataclass(frozen=True)
class Lens:
    """An equidistant lens whose image is corrected at zoom fit and turned.

    Flaws: an axis that misses the middle of the sensor by 1.2 % and 0.8 % of the width, decentred
    elements, a tilted sensor.

    Parameters
    ----------
    degrees : float
        Horizontal view.
    size : (int, int)
        Size of the distorted image in pixels; of the corrected one too, which a turn by 90 degrees
        makes upright.
    rotation : float
        Degrees by which the corrected picture is turned.
    nodes : int or "auto"
        Distance of the nodes; 1: where the subject is the memory side, the network is evaluated at
        every pixel.
    interpolation : str
        "fast", "gradient" or "directional".
    neurons : int
        Hidden neurons of its network.
    """
    degrees: float
    size: tuple
    rotation: float = 0.0
    nodes: int | str = 1
    interpolation: str = FAST.name
    neurons: int = NEURONS

    @property
    def corrected(self):
        """(width, height) of the corrected picture."""
        return self.size[::-1] if self.rotation == 90 else self.size

    @property
    def geometry(self):
        """:class:`Geometry` of the two pictures."""
        return Geometry(*self.corrected, *self.size,
                        interpolation=interpolation_of(self.interpolation))

    @cached_property
    def _camera(self):
        width, height = self.size
        return Camera.from_dict({
            "width": width, "height": height, "radial": "kb",
            "f_distorted": width / 2 / np.radians(self.degrees / 2),
            "centre": [(width - 1) / 2 + .012 * width, (height - 1) / 2 - .008 * width],
            "p": [.003, -.002], "tilt_rad": [.02, -.015]})

    def back_map(self, u, v):
        """Distorted pixel (x, y) of the corrected pixel (u, v)."""
        frame = self._camera.frame
        middle = [(size - 1) / 2 for size in self.size]
        turned = [(size - 1) / 2 for size in self.corrected]
        angle = np.radians(self.rotation)
        across, down = np.asarray(u) - turned[0], np.asarray(v) - turned[1]
        return self._camera.distort(*frame.ideal(
            middle[0] + np.cos(angle) * across - np.sin(angle) * down,
            middle[1] + np.sin(angle) * across + np.cos(angle) * down))

    def __str__(self):
        return f"{self.degrees:g}"


def trained(lens):
    """The descriptor of a lens.

    It is trained once and cached with the compiled simulations, until one of its source files or
    libraries changes.
    """
    def train(folder):
        pairs = training_grid(lens.back_map, lens.geometry)
        source = Source(pairs, lens.geometry, back_map=lens.back_map)
        choices = TrainingChoices(options=_OPTIONS, nodes=lens.nodes)
        train_camera(source, lens.neurons, choices).descriptor.save(folder / "net.toml")
    folder = built(key_of("lens", repr(lens), _trainer()), train)
    return Descriptor.load(folder / "net.toml")


@cache
def _trainer():
    """Digest of all that makes a descriptor of a lens: this file, the trainer and what they use."""
    return source_digest([__name__, "ncdc_model.training.pipeline"],
                         ["ncdc_model", "ncdc_spec"], ["numpy", "scipy"])
