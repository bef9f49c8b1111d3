"""Moves the view of a device as the mouse and the keys say."""

import math

from PySide6.QtCore import QObject, QPointF

from ncdc_host.gui.shown_views import LAYOUT, SELECTOR, ShownViews
from ncdc_spec.view_matrix import LIMITS, Angles

__all__ = ["ViewSteering"]

# The features of a view, and the names of Angles.
_NAMES = {name.capitalize(): name for name in LIMITS}
_KEY = 0.1              # of the picture's width that an arrow key moves
_ZOOM = 1.1             # a step of the wheel
_STEEPEST = 0.2         # cosine of the tilt from which on a drag does not turn the view faster


class ViewSteering(QObject):
    """Joins the :class:`PictureView` of a tab to the features Pan, Tilt, Roll and Zoom.

    What is under the cursor stays under it while it is dragged, but for the corners of a wide view.
    Of several views, the one under the cursor is selected first and moves then.
    """

    def __init__(self, tab):
        super().__init__(tab)
        self._tab, self._sent = tab, {}     # values that the device has not answered yet
        self._waiting, self._selecting = [], None   # (view, what to do); a change of the selection
        view, bar = tab.view, tab.bar
        view.dragged.connect(self.drag)
        view.wheeled.connect(self.magnify)
        view.pushed.connect(self.push)
        bar.steer.clicked.connect(self.steer)
        bar.reset.clicked.connect(self.reset)
        tab.session.written.connect(self._written)

    @property
    def possible(self):
        """Whether the device has a view, and sends it, and its lens states its camera."""
        infos = self._tab.infos or {}
        return ("ViewFocal" in infos and infos["ViewFocal"].value > 0
                and infos["CorrectionEnable"].value)

    @property
    def several(self):
        """Whether the device can show several views in its picture."""
        return self.possible and LAYOUT in self._tab.infos

    @property
    def _views(self):
        return ShownViews(self._tab.infos)

    def show(self, layout):
        """Show another layout of views: one of :data:`~ncdc_spec.view_layout.LAYOUTS`."""
        self._tab.set_feature(LAYOUT, layout)

    def enable(self, control):
        """Show the buttons of a device with a view; ``control``: it can be moved."""
        bar, on = self._tab.bar, control and self.possible
        for button in (bar.steer, bar.reset):
            button.setVisible(self.possible)
            button.setEnabled(on)
        if not on:
            self.steer(False)
            self._waiting = []
        self._show_outline()

    def toggle(self):
        """Begin to move the view by mouse and keys, or end it."""
        self.steer(not self._tab.view.steers)

    def steer(self, on):
        """Have mouse and keys move the device's view, or the picture in the window."""
        self._tab.bar.steer.setChecked(on)
        self._tab.view.steers = on
        self._show_outline()

    def drag(self, moved, start=None):
        """Turn the view at ``start`` so that its content moves by ``moved``, both QPointF in
        pixels; without ``start`` the selected one."""
        self._with(start, lambda: self._drag(moved))

    def _drag(self, moved):
        values, views = {name: self._value(name) for name in _NAMES}, self._views
        radius = self._tab.infos["ViewFocal"].value * values["Zoom"] * views.share(views.selected)
        x, y = (-side if views.mirrored(name) else side
                for side, name in ((moved.x(), "ReverseX"), (moved.y(), "ReverseY")))
        roll, tilt = (math.radians(values[name]) for name in ("Roll", "Tilt"))
        across = x * math.cos(roll) - y * math.sin(roll)
        down = x * math.sin(roll) + y * math.cos(roll)
        level = max(_STEEPEST, math.cos(tilt))
        self._set(Pan=values["Pan"] - math.degrees(math.atan(across / radius / level)),
                  Tilt=values["Tilt"] + math.degrees(math.atan(down / radius)))

    def push(self, direction):
        """Turn the selected view towards ``direction``, a QPointF, by a part of its width."""
        width = self._tab.shown.image.width() if self._tab.shown else 0
        views = self._views
        self.drag(QPointF(direction * (-_KEY * width * views.share(views.selected))))

    def magnify(self, steps, at=None):
        """Zoom the view at a point of the picture in by so many steps of the wheel."""
        self._with(at, lambda: self._set(Zoom=self._value("Zoom") * _ZOOM**steps))

    def reset(self):
        """Have the selected view look as the lens was trained."""
        self._with(None, lambda: self._set(**{name: getattr(Angles(), key)
                                              for name, key in _NAMES.items()}))

    def _with(self, point, act):
        """Call ``act()`` once the view at that point of the picture is selected."""
        views = self._views
        number = self._waiting[-1][0] if self._waiting else views.selected
        if point is not None:
            number = views.under(point)
        # The selected view may be none of this layout.
        self._waiting.append((number if number < len(views.areas) else 0, act))
        self._go_on()

    def _go_on(self):
        """Do what waits for its view, as far as that is selected."""
        while self._waiting and self._selecting is None:
            number, act = self._waiting[0]
            if number != self._views.selected:
                self._selecting = self._tab.set_feature(
                    SELECTOR, self._tab.infos[SELECTOR].choices[number])
                return
            del self._waiting[0]
            act()

    def _show_outline(self):
        """Mark the selected view, if it is one of several."""
        views = self._views if self.several else None
        self._tab.view.show_outline(views.rect(views.selected) if views and len(views.areas) > 1
                                    and self._tab.view.steers else None)

    def _value(self, name):
        return self._sent[name][1] if name in self._sent else self._tab.infos[name].value

    def _set(self, **values):
        for name, value in values.items():
            low, high = LIMITS[_NAMES[name]]
            value = min(max(value, low), high)
            if value != self._value(name):
                self._sent[name] = self._tab.set_feature(name, value), value

    def _written(self, name, serial):
        # Of several changes of a feature that wait for their turn, only the last one is answered.
        if name in self._sent and self._sent[name][0] <= serial:
            del self._sent[name]
        if name == SELECTOR and self._selecting is not None and self._selecting <= serial:
            self._selecting = None
            if self._waiting and self._waiting[0][0] != self._views.selected:
                self._waiting = []          # rejected, or changed by the panel
            self._go_on()
