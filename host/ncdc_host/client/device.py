"""The interface of every transport: a device with features, and a stream of its frames."""

import time
from abc import ABC, abstractmethod
from collections import deque
from dataclasses import dataclass

from ncdc_host.client.errors import BadValue, DeviceError, MalformedFrame, NoFrame, printable
from ncdc_host.client.frame import Frame

__all__ = ["Device", "FeatureInfo", "FrameStream", "Rate", "Statistics", "as_kind"]


@dataclass(frozen=True)
class FeatureInfo:
    """A feature of a device at one moment.

    Parameters
    ----------
    name : str
    kind : str
        "integer", "float", "boolean", "enumeration", "text" or "command".
    value : int, float, bool, str or None
        None of a command.
    writable : bool
        Whether it can be written now: false while it is locked, and for a monitor.
    minimum, maximum, increment : int, float or None
        Limits now, of numbers.
    unit : str
    choices : tuple of str
        Entries of an enumeration.
    text : str
        A sentence that describes it.
    category : str
    """
    name: str
    kind: str
    value: object
    writable: bool
    minimum: float | None = None
    maximum: float | None = None
    increment: float | None = None
    unit: str = ""
    choices: tuple = ()
    text: str = ""
    category: str = ""

    def __post_init__(self):
        # A device's texts come to terminals and windows: nothing in them may change those.
        if isinstance(self.value, str):
            object.__setattr__(self, "value", printable(self.value))
        object.__setattr__(self, "choices", tuple(map(printable, self.choices)))
        for name in ("name", "unit", "text", "category"):
            object.__setattr__(self, name, printable(getattr(self, name)))


@dataclass(frozen=True)
class Statistics:
    """Counters of a stream.

    Parameters
    ----------
    frames : int
        Whole frames handed out.
    lost : int
        Frames that were sent and did not arrive whole, resent packets included, and malformed
        ones; 0 over TCP.
    skipped : int
        Frames that no caller took in time; over TCP, frames of the device between two that were
        asked for.
    resent : int
        Packets that arrived at the second try; 0 over TCP, which does so by itself.
    rate : float
        Frames per second over the last two seconds.
    """
    frames: int
    lost: int
    skipped: int
    resent: int
    rate: float


class Rate:
    """Frames per second, of the last two seconds."""
    SECONDS = 2.0

    def __init__(self):
        self._times = deque()

    def count(self) -> None:
        """One more frame, now."""
        self._times.append(time.monotonic())
        self._forget()

    def _forget(self):
        while self._times and self._times[0] < time.monotonic() - self.SECONDS:
            self._times.popleft()

    @property
    def value(self) -> float:
        """The rate now; 0 before the second frame."""
        self._forget()
        if len(self._times) < 2:
            return 0.0
        return (len(self._times) - 1) / (self._times[-1] - self._times[0] or 1e-9)


class FrameStream(ABC):
    """Frames as they come; ``with device.stream() as frames`` ends the stream as well.

    Attributes
    ----------
    malformed : int
        Pictures that came whole and were none: see :class:`MalformedFrame`.
    trouble : str
        A sentence on the last of them; empty if a frame has come since.
    """
    malformed, trouble = 0, ""

    def next(self, timeout: float = 5.0) -> Frame:
        """The next :class:`~ncdc_host.client.frame.Frame`, waiting ``timeout`` seconds at most.

        Raises
        ------
        NoFrame
            If none came in time.
        DeviceGone
            If the device does not answer any more.
        """
        until = time.monotonic() + timeout
        while True:
            try:
                frame = self._take(until - time.monotonic())
            except MalformedFrame as error:
                self.malformed, self.trouble = self.malformed + 1, str(error)
                if time.monotonic() < until:
                    continue
            except NoFrame:
                if not self.trouble:
                    raise
            else:
                self.trouble = ""
                return frame
            raise NoFrame(f"no picture within {timeout:g} s: {self.trouble}")

    @abstractmethod
    def _take(self, timeout):
        """The next frame as of :meth:`next`, which may raise :class:`MalformedFrame` as well."""

    @property
    @abstractmethod
    def statistics(self) -> Statistics:
        """The :class:`Statistics` so far."""

    @abstractmethod
    def close(self) -> None:
        """End the stream; a second time does nothing."""

    def __iter__(self):
        while True:
            yield self.next()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Device(ABC):
    """An open device. Any thread may call it; calls that wait for each other are short.

    Attributes
    ----------
    url : str
    """
    url = ""

    @property
    @abstractmethod
    def access(self) -> str:
        """"control"; "monitor": reads and watches only; "lost": control or the device is gone."""

    @abstractmethod
    def names(self) -> list[str]:
        """Names of the features, in the order in which to show them."""

    @abstractmethod
    def info(self, name: str) -> FeatureInfo:
        """The :class:`FeatureInfo` of a feature; raises :class:`DeviceError` for an unknown one."""

    @abstractmethod
    def get(self, name: str) -> int | float | bool | str | None:
        """The value of a feature: an int, float, bool or str by its kind."""

    @abstractmethod
    def set(self, name, value):
        """Write a feature, and return its value as read back.

        A float is rounded to the device's next step. Texts are taken for any kind, as a command
        line gives them.

        Raises
        ------
        BadValue
            If the feature cannot have the value.
        Rejected
            If the device does not take it: the feature is locked while pictures stream, is
            read-only, or another user has control.
        """

    @abstractmethod
    def execute(self, name: str) -> None:
        """Run a command feature."""

    @abstractmethod
    def stream(self, packet_size: int | None = None,
               multicast: str | None = None) -> FrameStream:
        """A :class:`FrameStream`, begun.

        Parameters
        ----------
        packet_size : int, optional
            Bytes of a GVSP packet with IP and UDP header; the device's if absent. Over TCP
            without effect.
        multicast : str, optional
            Group that the pictures go to, so that monitors see them, too; GVSP only. A monitor
            joins the group that the controller has chosen.
        """

    def load_lens(self, descriptor):
        """Make ``descriptor`` the lens that LensSelector names, from the next frame on.

        Raises
        ------
        Rejected
            If its sizes, Bayer pattern, fill, nodes or interpolation differ from the device's, or
            it has more neurons.
        DeviceError
            If the transport cannot do it: Table I does not reach the corrector's registers.
        """
        raise DeviceError(f"{self.url} takes no lens: only GVCP reaches the corrector's registers")

    def lens_limits(self):
        """The :class:`~ncdc_host.client.lens.LensLimits` of :meth:`load_lens`.

        Raises
        ------
        DeviceError
            If the transport cannot read them: Table I does not reach the corrector's registers.
        """
        raise DeviceError(f"{self.url} takes no lens: only GVCP reaches the corrector's registers")

    @abstractmethod
    def close(self) -> None:
        """Give control back and close; a second time does nothing."""

    def features(self) -> dict[str, FeatureInfo]:
        """The :class:`FeatureInfo` of every feature by name."""
        return {name: self.info(name) for name in self.names()}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


_BOOLEANS = {**dict.fromkeys(("1", "true", "on", "yes"), True),
             **dict.fromkeys(("0", "false", "off", "no"), False)}


def as_kind(info, value):
    """``value``, perhaps a text, as the kind of the feature ``info`` wants it.

    Raises
    ------
    BadValue
        If it is none, or outside the limits.
    """
    if info.kind == "boolean":
        if str(value).lower() not in _BOOLEANS:
            raise BadValue(f"{info.name} is {value!r}, a boolean is needed")
        return _BOOLEANS[str(value).lower()]
    if info.kind in ("integer", "float"):
        return _number(info, value)
    if info.kind == "enumeration" and value not in info.choices:
        raise BadValue(f"{info.name} is {value!r}, one of {', '.join(info.choices)} is needed")
    return str(value)


def _number(info, value):
    try:
        number = (int if info.kind == "integer" else float)(value)
    except (ValueError, TypeError):
        raise BadValue(f"{info.name} is {value!r}, "
                       f"{'a whole' if info.kind == 'integer' else 'a'} number is needed") from None
    low, high = info.minimum, info.maximum
    # A float's limits may be rounded in the last digit on their way.
    slack = 1e-9 * abs(number) if info.kind == "float" else 0
    if (number != number or low is not None and number < low - slack
            or high is not None and number > high + slack):
        raise BadValue(f"{info.name} is {number:g}, the limits are {low:g} and {high:g}")
    if info.kind == "integer" and info.increment and (number - low) % info.increment:
        raise BadValue(f"{info.name} is {number}, steps of {info.increment} from {low} on are "
                       "needed")
    return number
