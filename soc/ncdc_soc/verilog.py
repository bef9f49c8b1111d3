"""Verilog of a LiteX design, reproducible, without LiteX's log on the terminal."""

import contextlib
import io
import logging
import re

__all__ = ["litex_verilog"]


def litex_verilog(platform, make, name):
    """The design that ``make()`` builds for ``platform``, and its Verilog with the top ``name``.

    LiteX's header is left out: it has the date in it.
    """
    logging.disable(logging.INFO)       # LiteX logs its whole tree of modules
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            design = make()
            text = platform.get_verilog(design, name=name).main_source
    finally:
        logging.disable(logging.NOTSET)
    return design, re.sub(r"^//.*\n", "", text, flags=re.MULTILINE)
