"""What pyproject.toml cannot say: the firmware's sources, which lie in no package, go into the
wheel as data of ``ncdc_soc``."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

SOURCE = Path("soc/ncdc_soc/firmware_source")
TARGET = Path("ncdc_soc/firmware_source")       # ncdc_soc.firmware looks for it there


class BuildPy(build_py):
    """The packages and the firmware, not the benches; an editable installation finds both in the
    checkout."""

    def finalize_options(self):
        super().finalize_options()
        if not self.editable_mode:
            self.packages = [name for name in self.packages
                             if name.partition(".")[0] != "ncdc_bench"]

    def run(self):
        super().run()
        if not self.editable_mode:
            for source, target in zip(self._sources(), self._targets()):
                Path(target).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(source, target)

    def get_outputs(self, include_bytecode=1):
        """Files that are made: uninstalling takes them away again."""
        return super().get_outputs(include_bytecode) + self._targets() * (not self.editable_mode)

    def _sources(self):
        return sorted(path for path in SOURCE.rglob("*") if path.is_file())

    def _targets(self):
        return [str(Path(self.build_lib, TARGET, path.relative_to(SOURCE)))
                for path in self._sources()]


setup(cmdclass={"build_py": BuildPy})
