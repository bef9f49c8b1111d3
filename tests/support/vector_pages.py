"""Reads the filled shapes of a page, PDF or SVG, and paints them: for pages of targets."""

import re
import zlib
from xml.etree import ElementTree

import cv2
import numpy as np

__all__ = ["painted", "shapes"]

_POINT_MM = 25.4 / 72
_BENDS = np.linspace(0, 1, 17)[1:]      # of a Bezier curve


def shapes(data):
    """((width, height), polygons (n, 2)) of a page in millimetres, from its upper left corner.

    The white ground is none of the shapes.
    """
    size, polygons = (_pdf if data.startswith(b"%PDF") else _svg)(data)
    whole = np.prod(size)
    return size, [p for p in polygons if np.prod(np.ptp(p, axis=0)) < 0.99 * whole]


def painted(data, per_mm):
    """Grey picture of a page, uint8, with so many pixels per millimetre; shapes are smooth at
    their edges."""
    size, polygons = shapes(data)
    fine = 4
    width, height = (int(round(side * per_mm)) * fine for side in size)
    image = np.full((height, width), 255, np.uint8)
    for polygon in polygons:
        # Middles of pixels are whole numbers there; the fraction has four bits.
        corners = np.round((polygon * per_mm * fine - .5) * 16).astype(np.int32)
        cv2.fillPoly(image, [corners], 0, cv2.LINE_AA, 4)
    return cv2.resize(image, (width // fine, height // fine), interpolation=cv2.INTER_AREA)


def _pdf(data):
    left, bottom, right, top = map(float, re.search(rb"/MediaBox \[([\d. ]+)\]", data)[1].split())
    assert (left, bottom) == (0, 0)
    polygons = []
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", data, re.DOTALL):
        try:
            text = zlib.decompress(stream).decode("latin-1")
        except zlib.error:
            continue                    # a font
        # Text has its own operators, between BT and ET.
        text = re.sub(r"BT.*?ET", "", text, flags=re.DOTALL)
        if re.search(r"\bcm\b", text.partition("h\n")[0]):
            raise AssertionError("a matrix before the shapes")
        polygons += _polygons(re.findall(r"([\d.\- ]+?) ([mlc])$|^(h)$", text, re.MULTILINE))
    return ((right * _POINT_MM, top * _POINT_MM),
            [np.array([0, top * _POINT_MM]) + p * (_POINT_MM, -_POINT_MM) for p in polygons])


def _svg(data):
    root = ElementTree.fromstring(data)
    width, height = (float(root.get(name).removesuffix("pt")) for name in ("width", "height"))
    assert root.get("viewBox") == f"0 0 {root.get('width')[:-2]} {root.get('height')[:-2]}"
    polygons = []
    for path in root.iter("{http://www.w3.org/2000/svg}path"):
        assert not path.get("transform")
        steps = re.findall(r"([MLCz])([\d.\- ]*)", path.get("d"))
        polygons += _polygons([(numbers, letter.lower().replace("z", ""), letter == "z")
                               for letter, numbers in steps])
    return (width * _POINT_MM, height * _POINT_MM), [p * _POINT_MM for p in polygons]


def _polygons(steps):
    """Closed outlines of (numbers, operator m, l or c, whether it closes), curves as lines."""
    found, outline = [], []
    for numbers, operator, closes in steps:
        corners = np.array(numbers.split(), float).reshape(-1, 2)
        if operator == "m":
            outline = [corners[0]]
        elif operator == "l":
            outline.append(corners[0])
        elif operator == "c":
            a, (b, c, d) = outline[-1], corners
            outline += [(1 - t)**3 * a + 3 * (1 - t)**2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
                        for t in _BENDS]
        elif closes:
            found.append(np.array(outline))
    return found
