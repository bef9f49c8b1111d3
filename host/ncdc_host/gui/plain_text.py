"""Labels and tool tips that show a text as it is: what a device says is never read as HTML.

Qt guesses whether a text is HTML, and HTML reads local files: an image of /dev/zero never ends.
"""

from PySide6.QtCore import Qt
from PySide6.QtGui import Qt as GuiQt
from PySide6.QtWidgets import QLabel

__all__ = ["PlainLabel", "plain_tip"]


class PlainLabel(QLabel):
    """A QLabel of plain text, for every text that is not written in this program."""

    def __init__(self, *text, **properties):
        super().__init__(*text, textFormat=Qt.TextFormat.PlainText, **properties)


def plain_tip(text):
    """The tool tip that shows ``text``: tool tips have no format but HTML that is escaped."""
    return GuiQt.convertFromPlainText(text, Qt.WhiteSpaceMode.WhiteSpaceNormal) if text else ""
