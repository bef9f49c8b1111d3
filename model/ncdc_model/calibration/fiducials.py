"""Names boards of fiducial markers that are another target, or that are not supported."""

import cv2
import numpy as np

from ncdc_model.calibration.tags import FAMILY

__all__ = ["other_board"]

_SIDE = 1300           # pixels of the longer side of the searched copy
_ENOUGH = 6            # different markers of one family: fewer may be texture
_CORRECTED = 0.3       # of the wrong cells that a family can correct: more may be texture
_ODD_BORDER = 0.1      # of the cells of a marker's border may be bright
# The largest dictionary of each family includes the smaller ones.
_FAMILIES = (FAMILY, "DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_7X7_1000",
             "DICT_ARUCO_ORIGINAL", "DICT_ARUCO_MIP_36h12", "DICT_APRILTAG_16h5",
             "DICT_APRILTAG_25h9")


def other_board(grey, kind=None):
    """Sentence that names the board of markers that a grey uint8 picture shows, or "".

    The markers of Kalibr's AprilGrid have a black border of two cells, all others of one.
    ``kind``: of the target that was looked for. An AprilGrid is not named if it is that, and no
    other board if it is a ChArUco board.
    """
    shrink = _SIDE / max(grey.shape)
    if shrink < 1:
        grey = cv2.resize(grey, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    count = 0 if kind == "aprilgrid" else _count(grey, FAMILY, 2)
    if count >= _ENOUGH:
        return (f"it shows an AprilGrid ({count} of its markers): --target aprilgrid:CxR, with its "
                f"columns and rows of markers, finds it")
    if kind in ("charuco", "aprilgrid"):
        return ""
    # Only of a target that was not named a ChArUco board has been looked for.
    without = "" if kind else " but no ChArUco board between them"
    counts = {family: _count(grey, family, 1) for family in _FAMILIES}
    family = max(counts, key=counts.get)
    if counts[family] < _ENOUGH:
        return ""
    return (f"it shows {counts[family]} markers of the family {family.removeprefix('DICT_')}"
            f"{without}: of boards of markers, charuco:CxR and aprilgrid:CxR are supported")


def _count(grey, family, border):
    """Number of different markers of the ``family`` with a border of ``border`` cells."""
    settings = cv2.aruco.DetectorParameters()
    settings.markerBorderBits, settings.errorCorrectionRate = border, _CORRECTED
    settings.maxErroneousBitsInBorderRate = _ODD_BORDER
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, family))
    ids = cv2.aruco.ArucoDetector(dictionary, settings).detectMarkers(grey)[1]
    return 0 if ids is None else len(np.unique(ids))
