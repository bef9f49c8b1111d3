"""Camera models: pinhole, radial, decentred, tilted, asymmetric, and their combination.

Every model has ``distort`` (ideal point to distorted point) and ``undistort`` (its inverse);
both take and return two arrays of a common shape, with not-a-number outside their domain.
"""

from ncdc_model.lens.camera import Camera
from ncdc_model.lens.flaws import AsymmetricSurface, BrownWeng, TiltedSensor
from ncdc_model.lens.frame import Frame, choose_frame, parse_zoom
from ncdc_model.lens.pinhole import Pinhole, rotation
from ncdc_model.lens.radial import AsariPolynomial, KannalaBrandt, Rational

__all__ = ["AsariPolynomial", "AsymmetricSurface", "BrownWeng", "Camera", "Frame", "KannalaBrandt",
           "Pinhole", "Rational", "TiltedSensor", "choose_frame", "parse_zoom", "rotation"]
