"""Live calibration from a camera of the PC or a film, without a device."""

from pathlib import Path

from PySide6.QtCore import QObject, Qt

from ncdc_host.client.frame import Frame
from ncdc_host.gui.calibration_dialog import CalibrationDialog
from ncdc_host.gui.live_dialog import LiveDialog
from ncdc_host.gui.shown import Shown
from ncdc_host.gui.source_reader import SourceReader
from ncdc_model.images import is_raw
from ncdc_spec.pixel_formats import BGR8, bayer_format

__all__ = ["LiveSource"]

_BAYER = "RGGB"         # of a network for pictures that come in colours


class LiveSource(QObject):
    """Reads a source, calibrates live, then makes a lens file of the pictures.

    Attributes
    ----------
    dialog : LiveDialog or CalibrationDialog
        The one that is open.
    """

    def __init__(self, name, parent):
        super().__init__(parent)
        self.name, self._parent = Path(name).name, parent
        self.reader = SourceReader(name, self)
        self.dialog = LiveDialog(self.name, parent)
        self.dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.dialog.frame_wanted.connect(self.reader.ask)
        self.dialog.complete.connect(self._train)
        self.dialog.finished.connect(self.reader.stop)
        self.reader.frame.connect(self._frame)
        self.reader.ended.connect(self.dialog.source_ended)
        self.reader.start()
        self.dialog.open()
        self.dialog.begin()

    def _frame(self, pixels, seconds):
        self.dialog.show_frame(pixels, seconds, _frame_of(pixels).picture())

    def _train(self):
        live = self.dialog
        self.dialog = CalibrationDialog(
            Shown.of(_frame_of(live.pixels)), None, [], 0, f"{self.name} has no corrector",
            self._parent)
        self.dialog.use_pictures(live.live)
        self.dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.dialog.open()


def _frame_of(pixels):
    """A frame as of a device, to look at."""
    return Frame(pixels, bayer_format(_BAYER) if is_raw(pixels) else BGR8, 0, 0)
