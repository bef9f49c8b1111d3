"""Options of a range of views."""

import re

from ncdc.cli.view_angles import VIEW_TEXTS, view_size
from ncdc_model.view_range import ViewRange
from ncdc_spec.errors import InputError
from ncdc_spec.view_matrix import LIMITS

__all__ = ["add_view_range", "angles_text", "report_lines", "view_range_of", "views_given"]

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_RANGE = re.compile(rf"({_NUMBER})(?::({_NUMBER}))?")


def add_view_range(parser, prefix=""):
    """Declare the options --pan, --tilt, --roll, --zoom and --view-size, each but the last with
    ``prefix`` before its name."""
    for name, text in VIEW_TEXTS.items():
        low, high = LIMITS[name]
        parser.add_argument(f"--{prefix}{name}", dest=f"range_{name}", metavar="LOW:HIGH",
                            help=f"{text} of the views, a range or one number, within {low:g} to "
                                 f"{high:g}")
    parser.add_argument("--view-size", metavar="WxH",
                        help="pixels of the views (default: those of the corrected picture)")


def view_range_of(args, descriptor):
    """The :class:`ViewRange` of the options; None without them.

    Raises
    ------
    InputError
        If a value is outside its limits, or the descriptor does not state its focal length.
    """
    if not views_given(args):
        return None
    given = {name: text for name in VIEW_TEXTS
             if (text := getattr(args, f"range_{name}")) is not None}
    return ViewRange.of(descriptor, {name: _interval(name, text) for name, text in given.items()},
                        view_size(args.view_size))


def views_given(args):
    """Whether an option of :func:`add_view_range` is given."""
    return any(getattr(args, name) is not None
               for name in (*(f"range_{name}" for name in VIEW_TEXTS), "view_size"))


def _interval(name, text):
    """(low, high) of the text of an option."""
    match = _RANGE.fullmatch(text)
    if not match:
        raise InputError(f"{name} is {text!r}, LOW:HIGH or one number is needed, as in -30:30")
    low, high = match.groups()
    return float(low), float(low if high is None else high)


def angles_text(angles):
    """A view in a few words; ``angles``: its numbers by name."""
    return ", ".join(f"{name} {angles[name]:.4g}" for name in VIEW_TEXTS)


def report_lines(report):
    """Lines on the error of the nodes in a range of views; none without it.

    ``report``: with ``nodes``, and the entries of
    :func:`ncdc_model.view_nodes.errors_report` if there is a range.
    """
    errors, own = dict(report.get("views_nodes_px", {})), str(report["nodes"])
    if own not in errors:
        return
    worst = errors.pop(own)
    yield (f"nodes {own} pixels apart add at most {worst['max']:.5f} px in the views tried, at "
           f"{angles_text(worst['view'])}")
    if errors:
        yield "others would add " + ", ".join(
            f"{error['max']:.5f} px (--nodes {nodes})" for nodes, error in errors.items())
