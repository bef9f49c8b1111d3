"""A host's files: drivers, lenses and the documentation's samples, of a small corrector."""

import re
import subprocess
from pathlib import Path

from cameras import barrel_descriptor
from ncdc_spec.registers.register_map import counters, registers

PAGE = Path(__file__).resolve().parents[2] / "docs" / "reference" / "drivers.md"
WIDE = barrel_descriptor((20, 16), (24, 18), hidden_neurons=3)
TELE = barrel_descriptor((18, 14), (22, 20), hidden_neurons=3, seed=5, bayer="GBRG",
                         strength=0.1, fill=(250, 20, 3))
ROWS = registers(WIDE.hidden_neurons, WIDE.formats)
COUNTERS = [r.name for r in counters(ROWS)]
C = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]


def samples(language):
    """The code of that language in the documentation, as one text."""
    return "\n".join(re.findall(rf"^```{language}\n(.*?)^```$", PAGE.read_text(),
                                re.MULTILINE | re.DOTALL))


def compile_c(folder, *arguments):
    done = subprocess.run([*C, *arguments], cwd=folder, text=True, capture_output=True)
    assert not done.returncode, done.stderr
