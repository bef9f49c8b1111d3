"""The options that choose white balance and tone."""

from ncdc_model.golden.colour import GREY_WORLD, ColourSums, gains_of
from ncdc_model.golden.tone import tone_named
from ncdc_spec.colour import COLOURS, Colour
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY, grey_world

__all__ = ["add_colour", "colour_choice", "colour_line", "colour_report", "has_gains"]


def add_colour(parser):
    """Declare the options --raw-balance, --crest, --white-balance and --tone."""
    parser.add_argument("--raw-balance", metavar="R,G,B",
                        help="gains of the raw frame's samples, before interpolation: it loses "
                             "less than --white-balance; the same limits, or "
                             f"{GREY_WORLD} likewise")
    parser.add_argument("--crest", choices=list(CRESTS), default="off",
                        help="directional interpolation: what is added where blending would cut "
                             "off crests (default: off)")
    parser.add_argument("--white-balance", metavar="R,G,B",
                        help="gains of the colours after interpolation, "
                             f"{1 / UNITY:.4f} to {LARGEST_GAIN / UNITY:.4f}, or {GREY_WORLD}: "
                             "those that give the frame's colours equal means")
    parser.add_argument("--tone", metavar="CURVE",
                        help="tone curve after the gains: linear (default), sRGB, or gamma:G, G "
                             "from 1 to 3, as in gamma:2.2")


def colour_choice(args):
    """Function that chooses the :class:`Colour` of a frame by the options; None without them.

    Its argument is a function that makes the :class:`~ncdc_model.golden.corrector.Corrected` frame
    with given gains before interpolation: ``grey-world`` needs it.

    Raises
    ------
    InputError
        If a gain or a tone is outside the limits, or is none.
    """
    crest = CRESTS[args.crest]
    if not has_gains(args) and not crest and args.raw_balance is None:
        return None
    tone = tone_named(_tone(args))
    raw_gains = _fixed_gains(args.raw_balance, "raw balance")
    gains = _fixed_gains(args.white_balance, "white balance")

    def choose(corrected_with):
        def estimated(present):
            return grey_world(ColourSums.of(corrected_with(present)).colours)

        before = raw_gains or estimated(NO_RAW_GAINS)
        return Colour(gains or estimated(before), tone, crest, before)

    return choose


def _fixed_gains(text, what):
    """The gains of an option of this ``text``; None if they are to be estimated."""
    if text is None:
        return Colour().gains
    return None if text == GREY_WORLD else gains_of(text, what)


def has_gains(args):
    """Whether the options need the hardware's gains after interpolation or tone curve."""
    return args.white_balance is not None or args.tone is not None


def _tone(args):
    """Name of the tone curve."""
    return "linear" if args.tone is None else args.tone


def colour_report(args, colour):
    """Entries of a report that describe ``colour``, which the options chose."""
    return {"raw_gains": [gain / UNITY for gain in colour.raw_gains],
            "gains": [gain / UNITY for gain in colour.gains], "tone": _tone(args),
            "tone_nodes": list(colour.tone), "crest": args.crest}


def colour_line(args, colour):
    """One line on ``colour``, and on gains that grey-world would choose larger than they can be."""
    line = f"gains {_decimal(colour.gains)}; tone {_tone(args)}; crest {args.crest}"
    if args.raw_balance is not None:
        line = f"raw gains {_decimal(colour.raw_gains)}; {line}"
    for option, gains in ((args.raw_balance, colour.raw_gains), (args.white_balance, colour.gains)):
        if option == GREY_WORLD and LARGEST_GAIN in gains:
            names = " and ".join(name for name, gain in zip(COLOURS, gains)
                                 if gain == LARGEST_GAIN)
            line += f"; {names} would need more than {LARGEST_GAIN / UNITY:.3f}, the largest gain"
    return line


def _decimal(gains):
    return ", ".join(f"{gain / UNITY:.3f}" for gain in gains)
