"""Errors between client and device, each with one sentence for people as its message."""

from ncdc_spec.errors import InputError

__all__ = ["BadUrl", "BadValue", "DeviceError", "DeviceGone", "MalformedFrame", "NoFrame",
           "NotInstalled", "Rejected", "printable"]


def printable(text):
    """``text`` of a device with the characters that could control a terminal as escapes."""
    return "".join(one if one.isprintable() else one.encode("unicode_escape", "replace").decode()
                   for one in str(text))


class DeviceError(Exception):
    """A device, or the way to it, does not do what it was asked; the message is one sentence."""

    def __init__(self, text=""):
        super().__init__(printable(text))


class BadUrl(DeviceError, InputError):
    """A text that is no URL of a device."""


class NotInstalled(DeviceError, InputError):
    """A package that reaches devices is missing; the message names the line to type."""


class DeviceGone(DeviceError):
    """The device does not answer any more, or never did."""


class Rejected(DeviceError):
    """The device rejects a value outside the limits, a feature that is locked while pictures
    stream, or control that another user holds."""


class BadValue(Rejected, InputError):
    """A value that the feature cannot have; nothing was sent."""


class MalformedFrame(DeviceError):
    """A picture whose bytes are not those of its size and format: of a device that errs, or of a
    stranger who sends in its name. Streams count it as lost and go on."""


class NoFrame(DeviceError):
    """No picture came within the time that was allowed; the next one may."""
