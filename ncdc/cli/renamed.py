"""Options that had another name until the release before this one."""

import argparse
import sys

__all__ = ["add_renamed"]


class _Renamed(argparse.Action):
    """Stores the value under the new name, converted if need be, and says which name that is."""

    def __init__(self, *args, new, convert, **options):
        super().__init__(*args, **options)
        self.new, self.convert = new, convert

    def __call__(self, parser, namespace, value, option=None):
        print(f"warning: {option} is called {self.new} now; the old name goes with the next "
              f"release", file=sys.stderr)
        setattr(namespace, self.dest, value if self.convert is None else self.convert(value))


def add_renamed(parser, old, new, *, convert=None, **options):
    """Accept ``old`` for the option ``new``, with a warning; no help names it.

    Parameters
    ----------
    parser : argparse.ArgumentParser or group
        Has ``new`` already.
    old, new : str
    convert : callable, optional
        The value in the new option's units.
    options
        Of ``add_argument``: ``type``, and ``dest`` where it is not that of ``new``.
    """
    options.setdefault("dest", new.removeprefix("--").replace("-", "_"))
    parser.add_argument(old, action=_Renamed, new=new, convert=convert, metavar="VALUE",
                        default=argparse.SUPPRESS, help=argparse.SUPPRESS, **options)
