"""A firmware that stands still is begun anew by the watchdog; a sound one never is."""

import shutil
from ipaddress import IPv4Address

import numpy as np
import pytest

import ncdc_soc.firmware as firmware
from cameras import barrel_descriptor
from ncdc_sim.system.soc import ADDRESS, SocModel, SocRun
from ncdc_soc.firmware import Identity
from peers import need

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_SIZE = (64, 48)
# The firmware prints "address: 00000000" before, of a network that is up and has none.
_HAS_ADDRESS = f"address: {int(IPv4Address(ADDRESS)):08x}\n"
_LOOP = "\tfor (;;) {\n"
_HANGS = "\tfor (;;) {\n\t\tif (now32() > 1000000u)\n\t\t\tfor (;;)\n\t\t\t\t;\n"
_TRAPS = "\tfor (;;) {\n\t\tif (now32() > 1000000u)\n\t\t\t__asm__ volatile(\"ebreak\");\n"


@pytest.mark.parametrize("edit,said", [(_HANGS, None), (_TRAPS, "exception ")])
def test_a_firmware_that_stands_still_begins_anew(edit, said, tmp_path, monkeypatch):
    """In an endless loop, and after an exception: three times, with an address each time."""
    need("riscv64-unknown-elf-gcc", "unshare", "ip")
    source = tmp_path / "firmware"
    shutil.copytree(firmware.FIRMWARE, source)
    main = (source / "main.c").read_text()
    assert main.count(_LOOP) == 1
    (source / "main.c").write_text(main.replace(_LOOP, edit))
    monkeypatch.setattr(firmware, "FIRMWARE", source)
    model = SocModel(barrel_descriptor(corrected=_SIZE, distorted=_SIZE),
                     np.zeros(_SIZE[::-1], np.uint8), identity=Identity(time_scale=500))
    with SocRun(model) as run:
        run.wait_for(lambda: run.screen.count(_HAS_ADDRESS) >= 3)
        assert run.screen.count("NCDC ") >= 3
        assert said is None or run.screen.count(said) >= 2
