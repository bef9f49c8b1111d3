"""What a tab is made of: the picture with its bars, and a column of panels."""

from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QGroupBox,
    QHBoxLayout,
    QScrollArea,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from ncdc_host.gui.elided_label import ElidedLabel
from ncdc_host.gui.histogram_view import HistogramView
from ncdc_host.gui.lens_panel import LensPanel
from ncdc_host.gui.message_bar import MessageBar
from ncdc_host.gui.picture_view import PictureView
from ncdc_host.gui.plain_text import PlainLabel
from ncdc_host.gui.settings_panel import SettingsPanel
from ncdc_host.gui.statistics_panel import StatisticsPanel
from ncdc_host.gui.view_bar import ViewBar

__all__ = ["TabWidgets"]

_PANEL = 332            # pixels that the settings want at least
_WIDEST = "120.0 pictures/s  ·  9999 lost"


class TabWidgets(QWidget):
    """The widgets of a tab, laid out; they do nothing as yet."""

    def __init__(self):
        super().__init__()
        self.view, self.bar, self.messages = PictureView(), ViewBar(), MessageBar()
        self.histogram, self.settings = HistogramView(), SettingsPanel()
        self.lenses, self.statistics = LensPanel(), StatisticsPanel()
        self.foot, self.pixel, self.rate = ElidedLabel(), PlainLabel(), PlainLabel()
        # As wide as what it mostly says: digits that come and go move nothing.
        self.rate.setMinimumWidth(self.rate.fontMetrics().horizontalAdvance(_WIDEST))
        self.rate.setAlignment(Qt.AlignmentFlag.AlignRight)
        self.panel = self._panels()
        splitter = QSplitter()
        splitter.addWidget(self._picture_and_bars())
        splitter.addWidget(self.panel)
        splitter.setStretchFactor(0, 1)
        splitter.setCollapsible(0, False)
        splitter.setSizes([10_000, self.panel.minimumWidth()])
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(splitter)

    def _panels(self):
        panel = QWidget()
        column = QVBoxLayout(panel)
        column.setContentsMargins(10, 8, 10, 10)
        group = QGroupBox("Histogram")
        QVBoxLayout(group).addWidget(self.histogram)
        for widget in (group, self.settings, self.lenses, self.statistics):
            column.addWidget(widget)
        column.addStretch(1)
        scroll = QScrollArea(widgetResizable=True)
        scroll.setFrameShape(QScrollArea.Shape.NoFrame)
        scroll.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        scroll.setWidget(panel)
        scroll.setMinimumWidth(max(_PANEL, panel.minimumSizeHint().width())
                               + scroll.verticalScrollBar().sizeHint().width())
        return scroll

    def _picture_and_bars(self):
        left = QWidget()
        column = QVBoxLayout(left)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(0)
        foot = QHBoxLayout()
        foot.setContentsMargins(8, 4, 8, 4)
        foot.addWidget(self.foot, 1)
        foot.addSpacing(8)
        foot.addWidget(self.pixel)
        foot.addSpacing(16)
        foot.addWidget(self.rate)
        column.addWidget(self.bar)
        column.addWidget(self.messages)
        column.addWidget(self.view, 1)
        column.addLayout(foot)
        return left
