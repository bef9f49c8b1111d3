"""The options that choose white balance and tone."""

from ncdc_model.golden.colour import GREY_WORLD, ColourSums, gains_of
from ncdc_model.golden.tone import tone_named
from ncdc_spec.colour import COLOURS, Colour
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY, grey_world

__all__ = ["add_colour", "colour_choice", "colour_line", "colour_report", "has_gains"]


def add_colour(parser):
    """Declare the options --crest, --white-balance and --tone."""
    parser.add_argument("--crest", choices=list(CRESTS), default="off",
                        help="directional interpolation: what is added where blending would cut "
                             "off crests (default: off)")
    parser.add_argument("--white-balance", metavar="R,G,B",
                        help=f"gains of the colours, {1 / UNITY:.4f} to {LARGEST_GAIN / UNITY:.4f},"
                             f" or {GREY_WORLD}: those that give the frame's colours equal means")
    parser.add_argument("--tone", metavar="CURVE",
                        help="tone curve after the gains: linear (default), sRGB, or gamma:G, G "
                             "from 1 to 3, as in gamma:2.2")


def colour_choice(args):
    """Function that chooses the :class:`Colour` of a frame by the options; None without them.

    Its argument is the :class:`~ncdc_model.golden.corrector.Corrected` frame, which ``grey-world``
    needs.

    Raises
    ------
    InputError
        If a gain or a tone is outside the limits, or is none.
    """
    crest = CRESTS[args.crest]
    if not has_gains(args) and not crest:
        return None
    tone = tone_named(_tone(args))
    if args.white_balance == GREY_WORLD:
        return lambda corrected: Colour(grey_world(ColourSums.of(corrected).colours), tone, crest)
    gains = Colour().gains if args.white_balance is None else gains_of(args.white_balance)
    colour = Colour(gains, tone, crest)
    return lambda corrected: colour


def has_gains(args):
    """Whether the options need the hardware's gains or tone curve."""
    return args.white_balance is not None or args.tone is not None


def _tone(args):
    """Name of the tone curve."""
    return "linear" if args.tone is None else args.tone


def colour_report(args, colour):
    """Entries of a report that describe ``colour``, which the options chose."""
    return {"gains": [gain / UNITY for gain in colour.gains], "tone": _tone(args),
            "tone_nodes": list(colour.tone), "crest": args.crest}


def colour_line(args, colour):
    """One line on ``colour``, and on gains that grey-world would choose larger than they can be."""
    line = ", ".join(f"{gain / UNITY:.3f}" for gain in colour.gains)
    line = f"gains {line}; tone {_tone(args)}; crest {args.crest}"
    if args.white_balance == GREY_WORLD and LARGEST_GAIN in colour.gains:
        names = " and ".join(name for name, gain in zip(COLOURS, colour.gains)
                             if gain == LARGEST_GAIN)
        line += f"; {names} would need more than {LARGEST_GAIN / UNITY:.3f}, the largest gain"
    return line
