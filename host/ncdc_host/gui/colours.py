"""The window's own colours, for light and dark themes alike."""

from PySide6.QtGui import QColor, QPalette

__all__ = ["contrast", "dimmed", "is_dark", "message_colours"]

# Of messages: paper and ink on a light theme, and on a dark one.
_LIGHT = {"error": ("#fde7e6", "#8c1d18"), "warning": ("#fff4d6", "#6b4a00"),
          "info": ("#e4effc", "#174a8b")}
_DARK = {"error": ("#4a1f1d", "#ffd9d6"), "warning": ("#44360f", "#ffe7a8"),
         "info": ("#1c3350", "#d2e4fb")}
_DIMMED = 0.7           # share of the text's colour in that of less important text


def is_dark(palette):
    """Whether text is lighter than its background."""
    return (palette.color(QPalette.ColorRole.WindowText).lightness()
            > palette.color(QPalette.ColorRole.Window).lightness())


def message_colours(kind, palette):
    """(paper, ink), QColors, of a message: "error", "warning" or "info"."""
    return tuple(map(QColor, (_DARK if is_dark(palette) else _LIGHT)[kind]))


def dimmed(palette, text=QPalette.ColorRole.WindowText, ground=QPalette.ColorRole.Window):
    """Colour of less important text on the role ``ground``, of which it is still readable."""
    above, below = palette.color(text), palette.color(ground)
    return QColor(*(round(_DIMMED * a + (1 - _DIMMED) * b) for a, b in zip(
        above.getRgb()[:3], below.getRgb()[:3])))


def contrast(one, other):
    """Contrast ratio of two QColors, 1 to 21, as WCAG 2.1 defines it; 4.5 is needed of text."""
    light, dark = sorted(map(_luminance, (one, other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def _luminance(colour):
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055)**2.4
              for part in colour.getRgbF()[:3]]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
