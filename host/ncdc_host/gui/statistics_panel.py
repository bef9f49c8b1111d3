"""Counters and rates of a stream."""

from PySide6.QtWidgets import QFormLayout, QGroupBox

from ncdc_host.gui.plain_text import PlainLabel, plain_tip

__all__ = ["StatisticsPanel"]

_ROWS = {
    "rate": ("Rate", "Pictures per second that arrive."),
    "data": ("Data", "Megabytes per second of their pixels."),
    "frames": ("Pictures", "Whole pictures received since the device was opened."),
    "lost": ("Lost", "Pictures that were sent and did not arrive whole."),
    "skipped": ("Skipped", "Pictures that were not taken in time, or, over TCP, not asked for."),
    "resent": ("Resent packets", "Packets that arrived at the second try."),
    "dropped": ("Dropped by device", "Frames that were due and not made in time."),
    "torn": ("Torn by device", "Frames that were overwritten while they were read."),
}


class StatisticsPanel(QGroupBox):
    """Shows the :class:`Statistics` of a stream and the device's own counters."""

    def __init__(self):
        super().__init__("Statistics")
        form = QFormLayout(self)
        self.values = {}
        for key, (name, text) in _ROWS.items():
            value = self.values[key] = PlainLabel("–")
            label = PlainLabel(name)
            for widget in (label, value):
                widget.setToolTip(plain_tip(text))
            form.addRow(label, value)

    def show_counts(self, statistics, frame_bytes):
        """Show what arrived, of pictures of ``frame_bytes`` bytes."""
        rate = statistics.rate
        self.values["rate"].setText(f"{rate:.1f} pictures/s")
        self.values["data"].setText(f"{rate * frame_bytes / 1e6:.1f} MB/s")
        for key in ("frames", "lost", "skipped", "resent"):
            self.values[key].setText(f"{getattr(statistics, key):,}".replace(",", " "))

    def show_device(self, infos):
        """Show the device's counters, of its features."""
        for key, name in (("dropped", "FramesDropped"), ("torn", "FramesTorn")):
            if name in infos:
                self.values[key].setText(f"{infos[name].value:,}".replace(",", " "))
