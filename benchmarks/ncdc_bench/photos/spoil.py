"""Defects of photos of a target; the known points move with the picture."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_bench.photos.targets import Photo

__all__ = ["blur", "brighten", "compress", "cover", "darken", "fill", "glare", "mirror_border",
           "invert", "moire", "noise", "on_clutter", "part_focus", "pen", "raw", "shake",
           "shade", "turn", "vignette", "warp"]

_SKIN = 208, 160, 130


def _colour(photo):
    return photo.image.copy() if photo.image.ndim == 3 else np.dstack([photo.image] * 3)


def _clipped(picture):
    return np.clip(np.rint(picture), 0, 255).astype(np.uint8)


def blur(photo, sigma):
    """Out of focus by a Gaussian of ``sigma`` pixels."""
    return replace(photo, image=cv2.GaussianBlur(photo.image, (0, 0), sigma))


def shake(photo, length):
    """The camera moved by ``length`` pixels to the side while it exposed."""
    kernel = np.zeros((1, length | 1))
    kernel[:] = 1 / kernel.size
    return replace(photo, image=cv2.filter2D(photo.image, -1, kernel))


def noise(photo, sigma, seed=2):
    """Grain of ``sigma`` grey levels."""
    grain = np.random.default_rng(seed).normal(0, sigma, photo.image.shape)
    return replace(photo, image=_clipped(photo.image + grain))


def darken(photo, part):
    """Exposed ``part`` of what it needs, with the sensor's noise of 1.2 grey levels."""
    return noise(replace(photo, image=_clipped(photo.image * part)), 1.2)


def brighten(photo, gain):
    """Exposed too long: white is clipped and flows over by a pixel."""
    wide = cv2.GaussianBlur(photo.image.astype(np.float32) * gain, (0, 0), 1.0)
    return replace(photo, image=_clipped(wide))


def compress(photo, quality=5):
    """Compress as a JPEG file of low quality."""
    data = cv2.imencode(".jpg", photo.image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    flag = cv2.IMREAD_COLOR if photo.image.ndim == 3 else cv2.IMREAD_GRAYSCALE
    return replace(photo, image=cv2.imdecode(data, flag))


def glare(photo, spots, radius=0.12):
    """White reflections of ``radius`` widths at ``spots`` in parts of width and height."""
    picture = photo.image.astype(np.float32)
    y, x = np.indices(picture.shape[:2])
    width, height = photo.size
    visible = [truth.visible.copy() for truth in photo.truths]
    for a, b in spots:
        shine = 330 * np.exp(-((x - a * width)**2 + (y - b * height)**2) / (radius * width)**2)
        picture += shine if picture.ndim == 2 else shine[:, :, None]
        for seen, truth in zip(visible, photo.truths):
            near = np.linalg.norm(truth.xy - (a * width, b * height), axis=1)
            seen &= near > 0.6 * radius * width
    return Photo(_clipped(picture), _seen(photo, visible))


def _seen(photo, visible):
    return tuple(replace(truth, visible=seen) for truth, seen in zip(photo.truths, visible))


def cover(photo, *outlines, colour=_SKIN):
    """Something of ``colour`` lies on the target; outlines in parts of width and height."""
    picture = _colour(photo)
    mask = np.zeros(picture.shape[:2], np.uint8)
    for outline in outlines:
        corners = np.rint(np.array(outline) * photo.size).astype(np.int32)
        cv2.fillPoly(mask, [corners], 255)
    # Fingers are round, and light and dark: half lit from the left.
    soft = cv2.GaussianBlur(mask, (0, 0), 0.004 * photo.size[0])
    solid = soft > 127
    depth = np.minimum(cv2.distanceTransform(solid.astype(np.uint8), cv2.DIST_L2, 3), 40) / 40
    picture[solid] = _clipped((0.7 + 0.3 * depth)[solid, None] * np.array(colour))
    visible = []
    for truth in photo.truths:
        at = np.clip(np.rint(truth.xy), 0, np.array(photo.size) - 1).astype(int)
        visible.append(truth.visible & ~solid[at[:, 1], at[:, 0]])
    return Photo(picture, _seen(photo, visible))


def fill(photo, picture, box):
    """``picture`` hides the part ``box`` (left, top, right, bottom in parts of the size)."""
    width, height = photo.size
    left, top, right, bottom = (int(round(value * size)) for value, size in
                                zip(box, (width, height, width, height)))
    image = _colour(photo)
    image[top:bottom, left:right] = picture[top:bottom, left:right]
    visible = [truth.visible & ~((truth.xy >= (left - 0.5, top - 0.5))
                                 & (truth.xy < (right - 0.5, bottom - 0.5))).all(axis=1)
               for truth in photo.truths]
    return Photo(image, _seen(photo, visible))


def pen(photo, lines, thick=3, colour=(25, 30, 90)):
    """Draw ``lines`` with a pen, each of two points in parts of the size."""
    picture = _colour(photo)
    for line in lines:
        ends = [tuple(np.rint(np.array(end) * photo.size).astype(int).tolist()) for end in line]
        cv2.line(picture, *ends, colour, thick, cv2.LINE_AA)
    return replace(photo, image=picture)


def shade(photo, part=0.35):
    """A shadow of ``part`` of the light right of a slanted edge."""
    y, x = np.indices(photo.image.shape[:2])
    edge = 1 / (1 + np.exp(-(x - 0.5 * photo.size[0] - 0.3 * (y - 0.5 * photo.size[1])) / 4))
    light = 1 - (1 - part) * edge
    return replace(photo, image=_clipped(
        photo.image * (light if photo.image.ndim == 2 else light[:, :, None])))


def warp(photo, matrix, size=None, ground=0):
    """Seen through a plane's ``matrix`` (3, 3), on ``ground``: grey, or an RGB picture."""
    size = size or photo.size
    image = _colour(photo)
    moved = cv2.warpPerspective(image, matrix, size, flags=cv2.INTER_AREA)
    mask = cv2.warpPerspective(np.ones(image.shape[:2], np.float32), matrix, size)
    ground = ground if np.ndim(ground) else np.full((size[1], size[0], 3), ground, np.uint8)
    share = mask[:, :, None]

    def project(xy):
        moved = np.column_stack([xy, np.ones(len(xy))]) @ matrix.T
        return moved[:, :2] / moved[:, 2:]
    return Photo(_clipped(moved * share + ground * (1 - share)),
                 tuple(truth.moved(project, size) for truth in photo.truths))


def turn(photo, degrees, zoom=1.0, shift=(0.0, 0.0), ground=0):
    """Turned and scaled about its middle and shifted by parts of its size."""
    middle = (np.array(photo.size) - 1) / 2
    matrix = np.eye(3)
    matrix[:2] = cv2.getRotationMatrix2D(middle.tolist(), degrees, zoom)
    matrix[:2, 2] += np.array(shift) * photo.size
    if zoom < 0.8:
        photo = blur(photo, 0.4 / zoom)
    return warp(photo, matrix, ground=ground)


def on_clutter(photo, street, zoom=0.5, degrees=0.0, shift=(0.2, 0.2)):
    """The whole picture small, as a print that lies on a ``street``."""
    return turn(photo, degrees, zoom, shift, street)


def mirror_border(photo, border=0.12, part=0.35):
    """A dark shiny frame around the picture that mirrors it with ``part`` of its light."""
    wide, high = (int(border * value) for value in photo.size)
    picture = cv2.copyMakeBorder(_colour(photo), high, high, wide, wide, cv2.BORDER_REFLECT)
    picture = picture.astype(np.float32)
    inner = np.zeros(picture.shape[:2], bool)
    inner[high:-high, wide:-wide] = True
    picture[~inner] = 10 + part * picture[~inner]
    return Photo(_clipped(picture), tuple(replace(truth, xy=truth.xy + (wide, high))
                                          for truth in photo.truths))


def raw(photo):
    """The raw Bayer frame of the picture under a reddish lamp."""
    lit = _colour(photo) * np.array([0.95, 0.7, 0.4])
    frame = lit[:, :, 1].copy()
    frame[0::2, 0::2], frame[1::2, 1::2] = lit[0::2, 0::2, 0], lit[1::2, 1::2, 2]
    return replace(photo, image=_clipped(frame))


def part_focus(photo, sigma, degrees=0.0, at=0.6, soft=0.03):
    """Blur by a Gaussian of ``sigma`` pixels beyond a line at the part ``at`` of the width.

    The line is turned by ``degrees``; the blur begins within about ``soft`` widths.
    """
    sharp = photo.image.astype(np.float32)
    beyond = 1 / (1 + np.exp(-_beyond(photo, degrees, at) / (soft * photo.size[0] / 2)))
    beyond = beyond if sharp.ndim == 2 else beyond[:, :, None]
    wide = cv2.GaussianBlur(sharp, (0, 0), sigma)
    return replace(photo, image=_clipped(sharp + beyond * (wide - sharp)))


def _beyond(photo, degrees, at):
    """Distances (h, w) in pixels to the right of a line turned by ``degrees``.

    At half of the height the line is at the part ``at`` of the width.
    """
    y, x = np.indices(photo.image.shape[:2])
    angle, (width, height) = np.radians(degrees), photo.size
    return (x - at * width) * np.cos(angle) + (y - 0.5 * height) * np.sin(angle)


def vignette(photo, corner):
    """The light falls off to the part ``corner`` in the picture's corners, as r^2 and r^4 do."""
    width, height = photo.size
    x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
    q = (x * x * width**2 + y * y * height**2) / (width**2 + height**2)
    light = 1 / (1 + (corner**-0.5 - 1) * q)**2
    picture = photo.image * (light if photo.image.ndim == 2 else light[:, :, None])
    return noise(replace(photo, image=_clipped(picture)), 1.2)


def moire(photo, part, period=23.0, degrees=20.0):
    """Photographed from a screen: bands of light, ``part`` of it, that differ by colour."""
    y, x = np.indices(photo.image.shape[:2])
    angle = np.radians(degrees)
    phase = 2 * np.pi * (x * np.cos(angle) + y * np.sin(angle)) / period
    bands = np.stack([np.sin(phase + k * 2.1) * np.sin(phase / 7.3 + k) for k in range(3)], axis=-1)
    return replace(photo, image=_clipped(_colour(photo) * (1 - part / 2 + part / 2 * bands)))


def invert(photo):
    """White on black."""
    return replace(photo, image=255 - photo.image)
