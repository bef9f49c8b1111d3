"""What pyproject.toml cannot say: the benches go into no wheel, and an editable installation has
them; the README goes into the metadata with links that work there."""

import re
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py


class BuildPy(build_py):
    """The packages without the benches, unless the installation is editable."""

    def finalize_options(self):
        super().finalize_options()
        if not self.editable_mode:
            self.packages = [name for name in self.packages
                             if name.partition(".")[0] != "ncdc_bench"]


def description():
    """The README without its relative pictures and links: a package index has no such files."""
    text = Path("README.md").read_text()
    text = re.sub(r"^!\[[^\]]*\]\((?!\w+:)[^)]*\)\n\n", "", text, flags=re.MULTILINE)
    return re.sub(r"(?<!!)\[([^\]]*)\]\((?!\w+:)[^)]*\)", r"\1", text)


setup(cmdclass={"build_py": BuildPy}, long_description=description(),
      long_description_content_type="text/markdown")
