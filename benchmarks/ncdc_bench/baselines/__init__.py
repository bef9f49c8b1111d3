"""Other maps fitted to the same points, for comparison with the network.

Each is a function of a :class:`~ncdc_model.training.problem.Problem` that returns the map
(u, v) to (x', y'), corrected pixels to distorted ones.
"""

from functools import partial

from ncdc_bench.baselines.asari import fit_asari
from ncdc_bench.baselines.mesh import fit_bicubic_mesh, fit_bilinear_mesh
from ncdc_bench.baselines.opencv import fit_brown, fit_fisheye, fit_full

__all__ = ["BASELINES"]

BASELINES = {
    **{f"pbm{order}-{kind}": partial(fit_asari, order=order, shared=kind == "shared")
       for kind in ("shared", "separate") for order in (6, 7, 8)},
    "brown5": fit_brown,
    "opencv-fisheye": fit_fisheye,
    "opencv-full": fit_full,
    "mesh8-bilinear": partial(fit_bilinear_mesh, step=8),
    "mesh128-bicubic": partial(fit_bicubic_mesh, step=128),
}
