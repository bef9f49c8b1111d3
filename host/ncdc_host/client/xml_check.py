"""Checks a device's GenICam XML before viva-genicam reads it, which crashes at some of it."""

import io
import zipfile
import zlib
from xml.parsers import expat

from ncdc_host.client.errors import DeviceError

__all__ = ["XML_BYTES_MAX", "check_xml", "unpacked"]

XML_BYTES_MAX = 16 << 20        # of the text, and of an archive
_FORMULA_MAX = 2000             # characters
_DEPTH_MAX = 100                # nesting of elements; length of a chain of nodes
_READS_MAX = 1_000_000          # nodes that one value depends on, each as often as it is read
# References that no value depends on.
_NO_VALUE = {"pMin", "pMax", "pInc", "pSelected", "pInvalidator", "pAlias", "pCastAlias", "pError"}


def unpacked(data):
    """The XML text of ``data``, which may be a ZIP archive of it; raises :class:`DeviceError`."""
    if not data.startswith(b"PK"):
        return data
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = archive.namelist()
            if not files:
                raise DeviceError("the device's XML is an empty archive")
            with archive.open(files[0]) as file:
                text = file.read(XML_BYTES_MAX + 1)
    except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError, EOFError,
            OSError) as error:
        raise DeviceError(f"the device's XML is a broken archive: {error}") from None
    return text


def check_xml(data):
    """The text of the XML ``data``, bytes, perhaps packed.

    Raises
    ------
    DeviceError
        If it is too large, broken, nested too deeply or cyclic.
    """
    text = unpacked(data)
    if max(len(text), len(data)) > XML_BYTES_MAX:
        raise DeviceError(f"the device's XML has more than {XML_BYTES_MAX >> 20} MB")
    reader = _Reader()
    try:
        reader.parser.Parse(text, True)
    except (expat.ExpatError, ValueError) as error:
        raise DeviceError(f"the device's XML is broken: {error}") from None
    _check_order(reader.used)
    return text


class _Reader:
    """Collects which node's value depends on which.

    Attributes
    ----------
    used : dict of str to list of str
        Names of the nodes that each node's value depends on.
    """
    def __init__(self):
        self.used = {}
        self._names = []        # of the elements around, None for those without
        self._text = []
        self.parser = parser = expat.ParserCreate()
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
        parser.CharacterDataHandler = self._characters
        parser.buffer_text = True

    @staticmethod
    def _doctype(*_):
        raise DeviceError("the device's XML has a document type, which GenICam does not")

    def _start(self, tag, attributes):
        if len(self._names) >= _DEPTH_MAX:
            raise DeviceError(f"the device's XML has more than {_DEPTH_MAX} elements in each other")
        outer = next((name for name in self._names if name is not None), None)
        # A variable's name is its own: it is an element of a node.
        self._names.append(attributes.get("Name") if outer is None else None)
        self._text = []

    def _characters(self, text):
        self._text.append(text)

    def _end(self, tag):
        self._names.pop()
        owner = next((name for name in self._names if name is not None), None)
        text = "".join(self._text).strip()
        self._text = []
        tag = tag.rpartition(":")[2]
        if tag.startswith("Formula") and len(text) > _FORMULA_MAX:
            raise DeviceError(f"the device's XML has a formula of {len(text)} characters, "
                              f"{_FORMULA_MAX} is the limit")
        if owner is not None and tag[:1] == "p" and tag[1:2].isupper() and tag not in _NO_VALUE:
            self.used.setdefault(owner, []).append(text)


def _check_order(used):
    """Raise :class:`DeviceError` at a circle, a long chain, or values that need too many reads."""
    known = {}              # name: (length of its longest chain, reads of its value)
    for first in used:
        waiting = [(first, iter(used[first]))]
        path = {first}
        if first in known:
            continue
        while waiting:
            name, others = waiting[-1]
            other = next((one for one in others if one not in known), None)
            if other in path:
                raise DeviceError(f"the device's XML is cyclic: {_shown(other)} follows from "
                                  "itself")
            if other is not None:
                waiting.append((other, iter(used.get(other, ()))))
                path.add(other)
                continue
            waiting.pop()
            path.discard(name)
            parts = [known[one] for one in used.get(name, ())]
            known[name] = (1 + max((length for length, _ in parts), default=0),
                           1 + sum(reads for _, reads in parts))
            if known[name][0] > _DEPTH_MAX:
                raise DeviceError(f"the device's XML has a chain of more than {_DEPTH_MAX} nodes, "
                                  f"from {_shown(name)} on")
            if known[name][1] > _READS_MAX:
                raise DeviceError(f"{_shown(name)} in the device's XML follows from more than "
                                  f"{_READS_MAX} others")


def _shown(name):
    return repr(name[:60])
