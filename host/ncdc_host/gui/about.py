"""Name and version of the program, and versions of its parts."""

import platform
from importlib.metadata import PackageNotFoundError, version

from PySide6.QtCore import Qt, qVersion
from PySide6.QtWidgets import QMessageBox

__all__ = ["about_box", "versions"]

_PARTS = ("PySide6-Essentials", "viva-genicam", "numpy", "opencv-python-headless", "scipy",
          "pyftdi")
_TEXT = """<b>NCDC {}</b>
<p>Client of cameras whose wide-angle distortion is corrected in hardware. It speaks Table I and II
of the paper over TCP, and GVCP and GVSP.</p>
<p>{}</p>
<p>Qt is used by PySide6 under the LGPL, version 3.</p>"""


def versions():
    """Version of each part by its name, dict of str; "not installed" of a package that is absent.

    Only packages' metadata is read: no part is imported for it.
    """
    found = {"NCDC": _version("ncdc"), "Python": platform.python_version(), "Qt": qVersion()}
    found |= {name: _version(name) for name in _PARTS}
    return found | {"System": platform.platform(terse=True)}


def about_box(parent=None):
    """The QMessageBox, which can be selected and copied for a report."""
    found = versions()
    rows = "<br>".join(f"{name}: {number}" for name, number in found.items() if name != "NCDC")
    box = QMessageBox(QMessageBox.Icon.NoIcon, "About NCDC", _TEXT.format(found["NCDC"], rows),
                      QMessageBox.StandardButton.Close, parent)
    box.setTextFormat(Qt.TextFormat.RichText)
    box.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse
                                | Qt.TextInteractionFlag.TextSelectableByKeyboard)
    box.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    return box


def _version(package):
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
