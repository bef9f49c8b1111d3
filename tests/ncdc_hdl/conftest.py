"""What the tests of a host's files share."""

import json
import shutil
import subprocess

import pytest

from drivers import TELE, WIDE, C, compile_c, samples
from kept import kept_folder
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.drivers.drivers import driver_files


@pytest.fixture(scope="module")
def corrector():
    return Corrector(WIDE)


@pytest.fixture(scope="module")
def kept(corrector, tmp_path_factory):
    """Folder with both descriptors, all that a host needs, and the documentation's samples.

    Nobody writes there; its name says what is in it, so that a bench on it is kept.
    """
    lenses = tmp_path_factory.mktemp("lenses")
    named = [(lenses / "wide.toml", WIDE), (lenses / "tele.toml", TELE)]
    for path, descriptor in named:
        descriptor.save(path)
    texts = driver_files(corrector, named) | {path.name: path.read_text() for path, _ in named}
    texts |= {"samples.c": samples("c"), "samples.py": samples("py")}

    def build(folder):
        for name, text in texts.items():
            (folder / name).write_text(text)
        compile_c(folder, "-shared", "-fPIC", "-o", "samples.so", "samples.c", "ncdc.c",
                  "ncdc_lenses.c")

    compiler = subprocess.run([C[0], "--version"], check=True, text=True, stdout=subprocess.PIPE)
    return kept_folder("drivers", build, json.dumps(texts), " ".join(C), compiler.stdout)


@pytest.fixture(scope="module")
def folder(kept, tmp_path_factory):
    """A copy of it to write in."""
    return shutil.copytree(kept, tmp_path_factory.mktemp("drivers"), dirs_exist_ok=True)
