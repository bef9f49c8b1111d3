"""Options of views: where the corrected picture looks, and what holds a film still."""

import re
from typing import Any

from ncdc_model.stabilise.gyro_file import load_gyroscope
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.view_map import view_map
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE
from ncdc_spec.view_matrix import LIMITS, Angles, PlaneCamera, view_matrix
from ncdc_spec.view_rows import MAX_MATRICES

__all__ = ["VIEW_TEXTS", "add_stabilisation", "add_view", "view_of", "view_options", "view_size"]

_STABILISATION: dict[str, Any] = {"gyro_axes": "x,y,z", "gyro_offset": 0.0, "readout_ms": 0.0,
                                  "smooth": 0.5}
VIEW_TEXTS = {"pan": "degrees to the right", "tilt": "degrees up", "roll": "degrees clockwise",
              "zoom": "magnification"}
"""What each number of a view is, for people."""


def add_view(parser):
    """Declare the options --pan, --tilt, --roll, --zoom and --view-size."""
    for name, text in VIEW_TEXTS.items():
        low, high = LIMITS[name]
        parser.add_argument(f"--{name}", type=float, metavar="Z" if name == "zoom" else "DEG",
                            help=f"{text}, {low:g} to {high:g} (default: "
                                 f"{getattr(Angles(), name):g})")
    parser.add_argument("--view-size", metavar="WxH",
                        help="pixels of the view (default: those of the corrected picture)")


def add_stabilisation(parser):
    """Declare the options --gyro, --gyro-axes, --gyro-offset, --readout-ms and --smooth."""
    parser.add_argument("--gyro", metavar="CSV",
                        help="samples of a gyroscope at the camera: columns time_s, x_rad_s, "
                             "y_rad_s, z_rad_s, or x_deg_s and so on")
    parser.add_argument("--gyro-axes", metavar="AXES",
                        help="axes of the gyroscope that are the camera's right, down and forward, "
                             "as in --gyro-axes=-y,x,z (default: x,y,z)")
    parser.add_argument("--gyro-offset", type=float, metavar="S",
                        help="time of the gyroscope when the film begins, seconds (default: 0)")
    parser.add_argument("--readout-ms", type=float, metavar="MS",
                        help="time in which a rolling shutter reads a frame (default: 0)")
    parser.add_argument("--smooth", type=float, metavar="S",
                        help="the view follows the camera's mean over about so many seconds; 0: "
                             "every movement (default: 0.5)")


def view_of(args, descriptor):
    """The :class:`ChosenView` of the options; None without them.

    Raises
    ------
    InputError
        If a value is outside its limits, the descriptor does not state its focal length, or the
        file of samples is not usable.
    """
    given = {name: value for name in LIMITS if (value := getattr(args, name)) is not None}
    if getattr(args, "gyro", None) is None:
        for name in _STABILISATION:
            if getattr(args, name, None) is not None:
                raise InputError(f"--{name.replace('_', '-')} is given, it needs --gyro")
        if not given and args.view_size is None:
            return None
    return ChosenView(args, descriptor, Angles(**given))


def view_options(args):
    """(option, value) of each option of :func:`add_view` and :func:`add_stabilisation`; the value
    is None if it is not given."""
    return [(f"--{name.replace('_', '-')}", getattr(args, name))
            for name in (*LIMITS, "view_size", "gyro", *_STABILISATION)]


class ChosenView:
    """A view that the options ask for.

    Attributes
    ----------
    size : (int, int)
        Width and height in pixels.
    angles : Angles
    stabiliser : Stabiliser or None
        Holds the picture of a moving camera still.
    """
    def __init__(self, args, descriptor, angles):
        self._trained = trained = PlaneCamera.of(descriptor)
        camera = trained.view(view_size(args.view_size), angles.zoom)
        self._descriptor, self.size, self.angles = descriptor, camera.size, angles
        self._matrix = view_matrix(trained, camera, angles.rotation)
        self.stabiliser = self._still = None
        if getattr(args, "gyro", None) is not None:
            axes, offset, readout, smoothing = (
                default if (value := getattr(args, name)) is None else value
                for name, default in _STABILISATION.items())
            self.stabiliser = Stabiliser(
                load_gyroscope(args.gyro, axes), trained, camera, angles.rotation,
                descriptor.geometry.distorted_height, readout / 1000, offset, smoothing)

    def maps(self, seconds):
        """The :func:`~ncdc_model.view_map.view_map` of the frame that began at ``seconds``."""
        if self.stabiliser:
            return view_map(self._descriptor, self.size, self.stabiliser.matrices(seconds))
        if self._still is None:
            self._still = view_map(self._descriptor, self.size, self._matrix)
        return self._still

    def at(self, seconds=0.0, matrices=MAX_MATRICES):
        """The :class:`~ncdc_spec.view.View` of the integer models.

        Parameters
        ----------
        seconds : float
            When the frame began, from the beginning of the film.
        matrices : int
            Most matrices of the table of a view that is held still.

        Raises
        ------
        InputError
            If the numbers are beyond those of the integer models, or the gyroscope has no samples
            of that time.
        """
        if self.stabiliser:
            return self.stabiliser.row_view(seconds, matrices)
        return self._trained.looking(self.angles, self.size)

    @property
    def report(self):
        """The view's numbers as in every report."""
        return {"view": {**vars(self.angles), "width": self.size[0], "height": self.size[1],
                         "stabilised": self.stabiliser is not None}}


def view_size(text):
    """(width, height) of an option; None without it."""
    if text is None:
        return None
    match = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    size = tuple(map(int, match.groups())) if match else (0, 0)
    if not all(MIN_SIZE <= side <= MAX_SIZE for side in size):
        raise InputError(f"the view's size is {text!r}, WIDTHxHEIGHT of {MIN_SIZE} to {MAX_SIZE} "
                         f"each is needed")
    return size
