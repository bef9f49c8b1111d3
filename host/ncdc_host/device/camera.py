"""Frames by the clock: what the emulated sensor and corrector have ready, and when."""

import threading
import time
from collections import OrderedDict
from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_host.device.auto_control import level_of
from ncdc_host.device.composed import ComposedCorrection
from ncdc_host.device.registers import Settings
from ncdc_host.device.sensor import Exposure, expose
from ncdc_model.correction import Correction, coloured
from ncdc_model.golden.colour import ColourSums
from ncdc_spec.colour import Colour
from ncdc_spec.pixel_formats import PixelFormat, packed
from ncdc_spec.view_layout import areas
from ncdc_spec.view_matrix import Angles, PlaneCamera, has_plane

__all__ = ["Camera", "Frame", "Picture", "picture_of"]

_CACHED = 24            # pictures, so that a scene that repeats itself is corrected only once
_CACHED_BYTES = 64 << 20


@dataclass(frozen=True)
class Frame:
    """A complete picture; its bytes are never written again.

    Parameters
    ----------
    number : int
        Number of the frame since reset.
    time_ns : int
        From reset to the beginning of the exposure.
    pixel_format : PixelFormat
    size, offset : (int, int)
        Width and height, column and row, pixels.
    data : memoryview
        The bytes, row by row.
    settings : Settings
        What it was made with.
    level : int
        Mean of some of its raw samples, in 16ths of a grey level.
    sums : ColourSums or None
        Of a corrected picture, before the gains.
    """
    number: int
    time_ns: int
    pixel_format: PixelFormat
    size: tuple
    offset: tuple
    data: memoryview
    settings: Settings
    level: int
    sums: ColourSums | None


@dataclass(frozen=True)
class Picture:
    """A picture's ``data``, uint8, with ``level`` and ``sums`` as of :class:`Frame`."""
    data: np.ndarray
    level: int
    sums: ColourSums | None


class Camera:
    """Makes frames on request, at the times of the frame rate.

    Parameters
    ----------
    light : Photo or MovingScene
    corrections : list of Correction
        One a lens, all of one geometry.
    registers : Registers
    noise : float
        See :class:`Exposure`.

    Attributes
    ----------
    corrections : list of Correction
    sums : ColourSums
        Of the last corrected picture, before the gains; zeros before the first.
    """
    def __init__(self, light, corrections, registers, noise):
        self._light, self._registers, self._noise = light, registers, noise
        self.corrections = list(corrections)
        self.sums = ColourSums(0, 0, 0, 0)
        self._bayer = corrections[0].descriptor.geometry.bayer
        self._reset = time.monotonic_ns()
        self._lock = threading.Lock()           # of rendering and of what it keeps
        self._pictures = OrderedDict()
        self._views = {}                        # corrections of the last views
        self._newest = None
        with registers.lock:
            self._anchor = (0, 0, registers.settings.rate_tenths)
            self._stale_until = 0               # frames before this one show older settings
        registers.on_change(self._changed)

    def now_ns(self):
        """Nanoseconds since reset."""
        return time.monotonic_ns() - self._reset

    def _slot(self, now):
        """Number of the newest frame whose exposure has begun."""
        number, start, tenths = self._anchor
        return number + (now - start) * tenths // 10_000_000_000

    def _time_of(self, number):
        first, start, tenths = self._anchor
        return start - (-(number - first) * 10_000_000_000 // tenths)

    def _changed(self):
        now, tenths = self.now_ns(), self._registers.settings.rate_tenths
        number = self._slot(now)
        self._stale_until = number + 1
        if tenths != self._anchor[2]:
            self._anchor = (number, now, tenths)

    def replace_lens(self, number, correction):
        """Replace the correction of a lens; frames begun before keep the old one."""
        with self._registers.lock:
            self.corrections[number] = correction
            self._changed()

    def newest(self):
        """The newest complete :class:`Frame` that has all settings written so far."""
        with self._registers.lock:
            number = max(self._slot(self.now_ns()), self._stale_until)
        return self.frame(number)

    def following(self, number, stop, later=False):
        """The next frame due after ``number``; None if the Event ``stop`` is set before.

        Frames that were due and not made in time are counted as dropped. ``later``: one whose
        exposure begins after this call; none is counted.
        """
        with self._registers.lock:
            due = self._slot(self.now_ns())
            wanted = max(due + later, number + 1, self._stale_until)
            if not later and number and wanted > number + 1:
                self._registers.dropped += wanted - number - 1
        frame = self.frame(wanted, stop)
        return None if stop.is_set() else frame

    def frame(self, number, stop=threading.Event()):
        """Frame ``number``, when its time has come."""
        while True:
            with self._registers.lock:
                begin, settings = self._time_of(number), self._registers.settings
                corrections = tuple(self.corrections)
            wait = (begin - self.now_ns()) / 1e9
            if wait <= 0:
                break
            # A change of the frame rate moves the time: look again from time to time.
            if stop.wait(min(wait, 0.05)):
                return None
        with self._lock:
            if self._newest is not None and self._newest.number == number:
                return self._newest
            picture = self._picture(settings, corrections, number)
            view = settings.view
            frame = Frame(number, begin, view.pixel_format, (view.width, view.height),
                          (view.x, view.y), memoryview(picture.data).cast("B"), settings,
                          picture.level, picture.sums)
            self.sums = picture.sums or self.sums
            if self._newest is None or number > self._newest.number:
                self._newest = frame
            return frame

    def _picture(self, settings, corrections, number):
        """The :class:`Picture`, made anew or cached."""
        position = self._light.position(number)
        # Read noise repeats with the scene; a still photo has eight patterns of it.
        seed = position or number % 8
        key = (settings.view, settings.lens, id(corrections[settings.lens]), settings.exposure_ns,
               settings.gain_eighths, settings.pattern, settings.colour, settings.layout,
               settings.looks, position, seed)
        if key in self._pictures:
            self._pictures.move_to_end(key)
            return self._pictures[key]
        picture = picture_of(self.raw(settings, position, seed), settings,
                             self._looking_as(settings, corrections[settings.lens]))
        self._pictures[key] = picture
        while len(self._pictures) > _CACHED or sum(
                p.data.nbytes for p in self._pictures.values()) > _CACHED_BYTES:
            self._pictures.popitem(last=False)
        return picture

    def _looking_as(self, settings, correction):
        """The correction into the views of ``settings``; those of the last ones stay, for speed."""
        lens = correction.descriptor
        if settings.view.pixel_format.raw or not has_plane(lens):
            return correction
        parts = areas(settings.layout, lens.geometry.corrected)
        if len(parts) == 1 and settings.looks[0] == Angles():
            return correction
        wanted = [(correction, look, part.size) for look, part in zip(settings.looks, parts)]
        # Frees those of other views before new ones are made.
        self._views = {key: view for key, view in self._views.items() if key in wanted}
        for key in wanted:
            if key not in self._views:
                self._views[key] = Correction(lens, correction.model,
                                              PlaneCamera.of(lens).looking(*key[1:]))
        views = [self._views[key] for key in wanted]
        return views[0] if len(views) == 1 else ComposedCorrection(lens, views, parts)

    def raw(self, settings, position, seed):
        """The whole raw frame of those settings as capture stores it, not mirrored."""
        exposure = Exposure(settings.exposure_ns / self._registers.reference_ns,
                            settings.gain_eighths / 8, settings.pattern, self._noise,
                            settings.colour.raw_gains)
        return expose(self._light.raw(position), exposure, self._bayer, seed)


def picture_of(raw, settings, correction):
    """The :class:`Picture` of the part that the view of ``settings`` shows, of the whole ``raw``
    frame.

    A corrected picture is corrected first and mirrored and cut then: hardware scans backwards
    and begins elsewhere, which gives the same pixels.
    """
    view, whole, sums = settings.view, raw, None
    if view.pixel_format.raw:
        raw = raw[view.y:view.y + view.height, view.x:view.x + view.width]
    else:
        corrected = correction(raw, settings.colour.crest)
        sums = _sums(corrected, correction.descriptor.geometry.fill)
        whole = corrected.picture
        if settings.colour != Colour():
            whole = coloured(corrected, settings.colour)
    if view.reverse_x:
        whole = whole[:, ::-1]
    if view.reverse_y:
        whole = whole[::-1]
    part = whole[view.y:view.y + view.height, view.x:view.x + view.width]
    return Picture(packed(part, view.pixel_format), level_of(raw), sums)


def _sums(corrected, fill):
    """The :class:`ColourSums` of a frame whose blank pixels have the colour ``fill``.

    The same as :meth:`ColourSums.of`, which takes a third of the time of a correction.
    """
    blank = int(np.count_nonzero(corrected.blank))
    red, green, blue = (int(total - blank * value)
                        for total, value in zip(cv2.sumElems(corrected.picture), fill))
    return ColourSums(red, green, blue, corrected.blank.size - blank)
