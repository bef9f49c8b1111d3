"""The true map of the example's corrected frame, known from its simulation."""

import cv2
import numpy as np

from ncdc_model.example.target import PITCH, page_dots, page_to_distorted
from ncdc_spec.errors import InputError

__all__ = ["true_map"]


def true_map(camera, photo, homography):
    """Exact back-map (u, v) -> (x, y) of the corrected frame that training chose.

    The corrected frame is a flat view of the target's page, so that the truth is the projection
    of the page's plane through the true camera.

    Parameters
    ----------
    camera : Camera
        The example's camera.
    photo : PhotoPoints
        Points found on the example's photo; their indices count from an arbitrary dot.
    homography : nine numbers
        From the points' indices to corrected pixels, in the descriptor's provenance.

    Raises
    ------
    InputError
        If the points are not those of the example's page.
    """
    to_page = _page_of_index(camera, photo)
    to_index = np.linalg.inv(np.reshape(homography, (3, 3)))

    def back_map(u, v):
        uv = np.stack([np.ravel(u), np.ravel(v)], axis=1).astype(np.float64)
        index = cv2.perspectiveTransform(uv[:, None], to_index)[:, 0]
        page = index @ to_page[:, :2].T + to_page[:, 2]
        x, y = page_to_distorted(camera, page).T
        return x.reshape(np.shape(u)), y.reshape(np.shape(v))

    return back_map


def _page_of_index(camera, photo):
    """Affine (2, 3) from lattice indices to page millimetres: whole dots, any orientation."""
    dots = page_dots().reshape(-1, 2)
    images = page_to_distorted(camera, dots)
    nearest = np.hypot(*(photo.xy[:, None] - images[None]).transpose(2, 0, 1)).argmin(axis=1)
    design = np.column_stack([photo.index, np.ones(len(photo.index))])
    solution = np.linalg.lstsq(design, dots[nearest] / PITCH, rcond=None)[0].T
    if np.abs(design @ np.round(solution).T - dots[nearest] / PITCH).max() > 1e-9:
        raise InputError("the points found are not those of the example's page")
    return PITCH * np.round(solution)
