"""The built-in example camera: a wide-angle lens with every flaw of the paper's Fig. 1."""

from ncdc_model.lens import Camera

__all__ = ["BAYER", "example_camera"]

BAYER = "RGGB"

# Horizontal view of 104 degrees, between an equidistant lens and a perspective one. The flaws:
# decentred elements, thin prism, a sensor tilted by about one degree, an axis off the
# middle by 5 pixels, and an asymmetric surface of up to 1.5 pixels.
_EXAMPLE = {
    "width": 640, "height": 480, "radial": "kb", "k": [0.035, 0.012, -0.004, 0.001],
    "p": [0.0011, -0.0008], "s": [-0.0004, 0.0002, 0.0003, 0.0001],
    "tilt_rad": [0.0155, -0.0120], "centre": [322.4, 236.2], "f_distorted": 338.0,
    "residual": {
        "scale": 0.60,
        "bump_centres": [[-0.55, -0.30], [0.45, 0.40], [0.10, -0.70]],
        "bump_sigmas": [0.50, 0.60, 0.55],
        "bump_vectors": [[-1.7, 0.6], [0.9, 1.8], [-0.8, -1.2]],
        "poly": [[-0.35, 0.20, 0.50, -0.15, 0.20, -0.10, 0.25, 0.15, -0.30],
                 [0.30, -0.25, 0.10, 0.20, -0.20, 0.15, 0.10, -0.30, 0.20]]},
}


def example_camera():
    """The :class:`Camera` of the example, 640x480, its corrected frame that of zoom fit."""
    return Camera.from_dict(_EXAMPLE)
