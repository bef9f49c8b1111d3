"""The stand-in for the corrector that the tests of the frame bench simulate."""

import re
from pathlib import Path

__all__ = ["copier"]


def copier(width=32, stream=False, fault=0):
    """Verilog of ``hdl/copier.v`` with its choices made, so that its ports can be read off."""
    text = (Path(__file__).parent / "hdl" / "copier.v").read_text()
    text = re.sub(r"`ifdef COPIER_STREAM\n(.*?)`else\n(.*?)`endif\n", rf"\{1 if stream else 2}",
                  text, flags=re.DOTALL)
    for name, value in (("`COPIER_WIDTH-1", width - 1), ("`COPIER_WIDTH/8", width // 8),
                        ("`COPIER_WIDTH", width), ("`COPIER_FAULT", fault)):
        text = text.replace(name, str(value))
    return text
