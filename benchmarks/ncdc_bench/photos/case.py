"""The class of a case, and the rendered targets that most cases start from."""

from collections.abc import Callable
from dataclasses import dataclass

from ncdc_bench.photos.targets import Pose

__all__ = ["EITHER", "REJECT", "USE", "Case", "board", "case", "charuco", "circles", "page"]

USE, REJECT, EITHER = "use", "reject", "either"


@dataclass(frozen=True)
class Case:
    """Photos that are calibrated together.

    Parameters
    ----------
    name : str
    expect : tuple of str
        Expected result of each photo: use, reject or either.
    target : str
        As of ``ncdc calibrate --target``.
    make : callable
        Takes a :class:`Bank`, gives the photos.
    word : str
        Regular expression that a warning of false points must match to count.
    """
    name: str
    expect: tuple
    target: str
    make: Callable
    word: str = ""


def case(name, expect, make, target="auto", word=""):
    """A :class:`Case` of one photo, or of as many as there are expectations."""
    many = isinstance(expect, tuple)
    return Case(name, expect if many else (expect,), target,
                make if many else lambda bank: [make(bank)], word)


def page(bank, pose=Pose(step=0.062, turn=4.0), clutter=True, size=(25, 18), **more):
    """A page of dots."""
    return bank.render(("dots", *size, pose), clutter=clutter, **more)


def circles(bank, pose=Pose(step=0.13), clutter=True, size=(9, 7), **more):
    """A grid of circles."""
    return bank.render(("circles", *size, pose), clutter=clutter, **more)


def board(bank, pose=Pose(step=0.16), clutter=True, size=(8, 6), **more):
    """A chessboard."""
    return bank.render(("chessboard", *size, pose), clutter=clutter, **more)


def charuco(bank, pose=Pose(step=0.16), clutter=True, size=(9, 7), **more):
    """A ChArUco board."""
    return bank.render(("charuco", *size, pose), clutter=clutter, **more)
