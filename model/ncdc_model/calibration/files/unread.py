"""Entries of a camera file that its reader does not know: distortion must not be lost there."""

import re
from collections import deque

import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["check_read", "may_bend"]

# Parts of a name that speak of distortion, whole words of one, and names of one letter.
_PARTS = re.compile(r"dist(?!anc|ribu)|coef|radial|tangen|decent|prism|poly(?!gon)|brown|"
                    r"fish_?eye|kannala|omni|mirror|warp|zernike|spline|aberrat|mapping")
_WORDS = re.compile(r"[dkpsab]\d{1,2}|[kp]_\d|[dk]_(left|right|[lr\d])|kc|kb\d?|kappa_?\d*|xi|"
                    r"alpha|beta|gamma|lambda|tau_?[xy]?|omega|poly|ss|invpol|ocam|lens_?(model|params?|parameters?)")
_LETTERS = frozenset("abcdkw")
# Text that names a model of distortion, in an entry that states a kind.
_KIND = re.compile(r"type|model|projection|lens")
_MODELS = re.compile(r"fish_?eye|equidist|kannala|omni|unified|double|eucm|division|"
                     r"scaramuzza|ocam|brown|radtan|rational|plumb", re.IGNORECASE)
# Words of which the names of other entries consist.
_HARMLESS = frozenset("""
    aabb accuracy applied area aspect auto average avg baseline binning bits board boards
    calibration cam camera cameras center centre channels chess chessboard colmap color colour
    cols columns comment confidence corner corners count cov covariance created cx cy date
    datetime depth description dev deviation deviations device distance do e enable err error
    errors essential exposure extrinsic extrinsics f far file files flags focal focus fps frame
    framerate frames full fundamental fx fy gain grid group h header height hfov id im image
    images img imgpoints imgs index initial integer intrinsic intrinsics is keypoints left
    length loading map mapx mapy marker matrices matrix max mean min model mono mtx n name names
    nb near new nframes normal nr nsec nsecs num number objpoints offset op optimal orientation
    original override p path paths pattern per pitch pixel ply point points pose poses position
    principal proj projection q quality r rate ratio rectification rectified rectify render
    reproj reprojection res resolution ret retval right rms roi rot rotation rotations row rows
    rvec rvecs scale scene sd sec secs sensor seq serial setup sharpness side size skew spacing
    square squares stamp std stereo t table target time timestamp total transform translation
    translations tvec tvecs unit units up used valid version vfov view views w width x y z
""".split())


def check_read(table, read, bent=True):
    """Reject an entry of ``table`` that may be distortion and that its reader does not know.

    Parameters
    ----------
    table : dict
        Names and values of one camera.
    read : collection of str
        Names that the reader understands, with all that they hold.
    bent : bool
        Whether the reader has found distortion. If not, the name of every entry that holds
        numbers must consist of harmless words.

    Raises
    ------
    InputError
        That names the entry.
    """
    waiting = deque((str(name), str(name), value, bent) for name, value in table.items()
                    if name not in read)
    while waiting:
        path, name, value, bent = waiting.popleft()
        numbers, text = _content(value)
        if may_bend(name, value) and (numbers or text) or (
                text and _KIND.search(name.lower()) and _MODELS.search(str(value))):
            raise InputError(f"the entry {path} may be distortion, which is not read from this "
                             f"name: give it a name that is known, or remove it")
        harmless = bent or set(_parts(name, "a-z")) <= _HARMLESS
        if numbers and not harmless:
            raise InputError(f"the file holds no distortion under a name that is known, and the "
                             f"entry {path} may be some: rename it, or state distortion_model: "
                             f"none")
        waiting += [(f"{path}.{key}", name if isinstance(key, int) else str(key), part, harmless)
                    for key, part in _inner(value)]


def may_bend(name, value=None):
    """Whether an entry of this ``name`` may be distortion; K1 or P2 of nine numbers is a matrix."""
    snake = "_".join(_parts(name, "a-z0-9"))
    if re.fullmatch("[a-z]_?[0-9]?", snake) and _count(value) in (9, 12, 16):
        return False
    return (snake in _LETTERS or bool(_PARTS.search(snake))
            or any(_WORDS.fullmatch(part) for part in (snake, *snake.split("_"))))


def _parts(name, letters):
    """Words of a name in lower case; camelCase and snake_case are split."""
    name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", str(name)).lower()
    return [part for part in re.split(f"[^{letters}]+", name) if part]


def _plain(value):
    """``value`` with matrices and arrays as lists."""
    if isinstance(value, dict) and "data" in value:
        value = value["data"]
    return value.tolist() if isinstance(value, np.ndarray) else value


def _count(value):
    value = _plain(value)
    return sum(map(_count, value)) if isinstance(value, (list, tuple)) else 1


def _inner(value):
    """Names and values within ``value``, if it is a table or a list that holds tables."""
    value = _plain(value)
    if isinstance(value, dict):
        return list(value.items())
    if isinstance(value, (list, tuple)):
        parts = [(k, part) for k, part in enumerate(value) if isinstance(part, (dict, list))]
        return parts if any(isinstance(part, dict) or _inner(part) for _, part in parts) else []
    return []


def _content(value):
    """Whether ``value`` holds a number that is not 0, and whether it holds text or true."""
    value = _plain(value)
    if isinstance(value, (dict, list, tuple)):
        found = [_content(part) for part in (value.values() if isinstance(value, dict) else value)]
        return any(numbers for numbers, _ in found), any(text for _, text in found)
    if isinstance(value, str):
        text = value.strip().lower()
        return bool(re.search(r"[1-9]", text)) and not re.search("[a-df-z]", text), text not in (
            "", "none", "no", "off", "false", "null") and not re.fullmatch(r"[-+0.,;\s\[\]]*", text)
    if isinstance(value, (bool, np.bool_)):
        return False, bool(value)
    return isinstance(value, (int, float, np.number)) and bool(value), False
