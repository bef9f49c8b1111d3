"""What pyproject.toml cannot say: the benches go into no wheel, and an editable installation has
them."""

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildPy(build_py):
    """The packages without the benches, unless the installation is editable."""

    def finalize_options(self):
        super().finalize_options()
        if not self.editable_mode:
            self.packages = [name for name in self.packages
                             if name.partition(".")[0] != "ncdc_bench"]


setup(cmdclass={"build_py": BuildPy})
