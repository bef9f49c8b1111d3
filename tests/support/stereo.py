"""The rectification maps of a simulated stereo pair, by OpenCV."""

import cv2
import numpy as np

__all__ = ["stereo_maps"]

# Left and right: focal lengths over the width, principal point off the middle over the width.
_CAMERAS = ((.640625, .6412656), (.0049, -.0076)), ((.6431875, .6428672), (-.0088, .0042))
_DISTORTION = (-.31, .118, .0006, -.0004, -.021), (-.305, .111, -.0005, .0007, -.018)
_ROTATION, _BASELINE = (.012, -.035, .008), (-120.0, 1.3, -2.1)      # radians, millimetres


def stereo_maps(width, height, alpha=0.0):
    """((x, y) of the left, (x, y) of the right camera), float32 as initUndistortRectifyMap gives.

    Barrel lenses that see 89 degrees across the width, turned by 2 degrees to each other and
    mounted 120 mm apart. ``alpha``: as in ``cv2.stereoRectify``, 0: only pixels with a source, 1:
    all of the pictures, with corners that have none.
    """
    matrices = [np.array([[fx * width, 0, width / 2 + cx * width],
                          [0, fy * width, height / 2 + cy * width], [0, 0, 1]])
                for (fx, fy), (cx, cy) in _CAMERAS]
    distortions = [np.array([numbers]) for numbers in _DISTORTION]
    turned, _ = cv2.Rodrigues(np.array(_ROTATION))
    left, right, *projections = cv2.stereoRectify(
        matrices[0], distortions[0], matrices[1], distortions[1], (width, height), turned,
        np.array([_BASELINE]).T, alpha=alpha)[:4]
    return [cv2.initUndistortRectifyMap(matrix, bend, turn, projection, (width, height),
                                        cv2.CV_32FC1)
            for matrix, bend, turn, projection in zip(matrices, distortions, (left, right),
                                                      projections)]
