"""Camera files as OpenCV writes them, and points of the ideal plane."""

import cv2
import numpy as np

__all__ = ["FISHEYE", "MATRIX", "ideal_points", "opencv_file"]

MATRIX = np.array([[300.0, 0, 318.5], [0, 300.0, 241.25], [0, 0, 1]])
FISHEYE = [.02, -.006, .002, -.0005]


def opencv_file(path, coefficients, **more):
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", MATRIX)
    storage.write("distortion_coefficients", np.array([coefficients]).T)
    for name, value in more.items():
        storage.write(name, value)
    storage.release()
    return path


def ideal_points():
    return (grid.ravel() for grid in np.meshgrid(np.linspace(-.9, .9, 9), np.linspace(-.7, .7, 7)))
