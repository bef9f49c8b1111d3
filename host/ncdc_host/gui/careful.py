"""Inputs that scrolling past them does not change."""

from PySide6.QtCore import Qt

__all__ = ["Careful"]


class Careful:
    """Before a widget's class among the bases: the wheel changes it only after a click or Tab.

    Without, the wheel itself would give some widgets the focus, and then change them.
    """

    def __init__(self, *arguments, **properties):
        super().__init__(*arguments, **properties)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event):
        if self.hasFocus():
            super().wheelEvent(event)
        else:
            event.ignore()
