"""Options that had another name until the release before this one."""

import argparse
import sys

__all__ = ["add_renamed"]


class _Renamed(argparse.Action):
    """Stores the value under the new name, converted if need be, and says which name that is."""

    def __init__(self, *args, new, convert, append, **options):
        super().__init__(*args, **options)
        self.new, self.convert, self.append = new, convert, append

    def __call__(self, parser, namespace, value, option=None):
        print(f"warning: {option} is called {self.new} now; the old name goes with the next "
              f"release", file=sys.stderr)
        value = value if self.convert is None else self.convert(value)
        if self.append:
            value = [*(getattr(namespace, self.dest, None) or ()), value]
        setattr(namespace, self.dest, value)


def add_renamed(parser, old, new, *, convert=None, append=False, **options):
    """Accept ``old`` for the option ``new``, with a warning; no help names it.

    Parameters
    ----------
    parser : argparse.ArgumentParser or group
        Has ``new`` already.
    old, new : str
    convert : callable, optional
        The value in the new option's units.
    append : bool
        The option may be given several times: its value is a list.
    options
        Of ``add_argument``: ``type``, and ``dest`` where it is not that of ``new``.
    """
    options.setdefault("dest", new.removeprefix("--").replace("-", "_"))
    parser.add_argument(old, action=_Renamed, new=new, convert=convert, append=append,
                        metavar="VALUE", default=argparse.SUPPRESS, help=argparse.SUPPRESS,
                        **options)
