"""What the tests of a host's files share."""

import pytest

from drivers import TELE, WIDE, compile_c, samples
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files


@pytest.fixture(scope="module")
def corrector():
    return Corrector(WIDE)


@pytest.fixture(scope="module")
def folder(corrector, tmp_path_factory):
    """Folder with both descriptors, all that a host needs, and the documentation's samples."""
    folder = tmp_path_factory.mktemp("drivers")
    named = [(folder / "wide.toml", WIDE), (folder / "tele.toml", TELE)]
    for path, descriptor in named:
        descriptor.save(path)
    texts = driver_files(corrector, named) | {
        "samples.c": samples("c"), "samples.py": samples("py")}
    for name, text in texts.items():
        (folder / name).write_text(text)
    compile_c(folder, "-shared", "-fPIC", "-o", "samples.so", "samples.c", "ncdc.c",
              "ncdc_lenses.c")
    return folder
