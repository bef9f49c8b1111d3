"""The whole system in simulation, with an EEPROM on the sensor's bus, by Debian's Aravis."""

import pytest

from eeprom_images import BUILT_IN, GOOD, OTHER
from ncdc_sim.system.soc import SocRun
from soc_clients import OPEN, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_LOOK = OPEN + """
with device.stream() as stream:
    for _ in range(3):
        take(stream)
print(json.dumps([device.get("EepromStatus"), len(taken)]))
"""


@pytest.mark.parametrize("content,status", [(GOOD, "Loaded"), (GOOD[:-1], "Checksum")])
def test_its_lens_is_that_of_the_pictures(model, tmp_path, content, status):
    """A damaged image leaves the built-in lens."""
    assert model.descriptor.digest == BUILT_IN.digest
    with SocRun(model, eeprom=content) as run:
        found, count = peer(run, _LOOK, tmp_path)
    lens = OTHER if status == "Loaded" else BUILT_IN
    assert found == status
    goldens = [model.golden(lens=one).picture for one in (BUILT_IN, OTHER)]
    assert matches(tmp_path, count, goldens) == 3 * [int(lens is OTHER)]
