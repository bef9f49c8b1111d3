"""The options of waveforms, ``--vcd`` and ``--fst``."""

from pathlib import Path

from ncdc_sim.waves import Waves
from ncdc_spec.errors import InputError

__all__ = ["add_waves", "waves_of"]


def add_waves(parser):
    """Declare the options."""
    parser.add_argument("--vcd", metavar="FILE",
                        help="write every signal's changes, for a waveform viewer: large, and slow")
    parser.add_argument("--fst", metavar="FILE",
                        help="the same, packed, for GTKWave or Surfer")


def waves_of(args):
    """The :class:`Waves` that are asked for, or None.

    Raises
    ------
    InputError
        If both formats are.
    """
    if args.vcd and args.fst:
        raise InputError(f"waveforms go to {args.vcd} or to {args.fst}: a run writes one format, "
                         "--vcd or --fst")
    path = args.vcd or args.fst
    return Waves(Path(path), "vcd" if args.vcd else "fst") if path else None
