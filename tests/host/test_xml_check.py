"""XML that crashes viva-genicam is rejected before it reads it; what is accepted does not."""

import io
import subprocess
import sys
import zipfile

import pytest

from devices import device
from ncdc_host.client import xml_check
from ncdc_host.client.devices import open_device
from ncdc_host.client.errors import DeviceError
from ncdc_host.client.xml_check import check_xml
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.genicam import genicam_xml

HEAD = genicam_xml().partition(b"<Category")[0]
REGISTER = ('<IntReg Name="R"><Address>0x10000</Address><Length>4</Length>'
            '<AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>'
            '<Endianess>BigEndian</Endianess></IntReg>')


def document(nodes):
    """XML with the one feature A, which ``nodes`` describe."""
    return HEAD + ('<Category Name="Root"><pFeature>All</pFeature></Category><Category Name="All">'
                   f'<pFeature>A</pFeature></Category>{REGISTER}{nodes}<Port Name="Device"/>'
                   '</RegisterDescription>').encode()


def integer(name, inside):
    return f'<Integer Name="{name}">{inside}</Integer>'


def chain(length):
    names = ["A", *(f"N{k}" for k in range(1, length - 1)), "R"]
    return document("".join(integer(one, f"<pValue>{other}</pValue>")
                            for one, other in zip(names, names[1:])))


def knife(formula, variables=()):
    return ('<IntSwissKnife Name="K">'
            + "".join(f'<pVariable Name="V{k}">{used}</pVariable>'
                      for k, used in enumerate(variables))
            + f"<Formula>{formula}</Formula></IntSwissKnife>" + integer("A", "<pValue>K</pValue>"))


def doubling(count):
    """Each node follows from the next one twice."""
    return document(integer("A", "<pValue>K0</pValue>") + "".join(
        f'<IntSwissKnife Name="K{k}"><pVariable Name="X">{used}</pVariable>'
        f'<pVariable Name="Y">{used}</pVariable><Formula>X+Y</Formula></IntSwissKnife>'
        for k in range(count) for used in [f"K{k + 1}" if k + 1 < count else "R"]))


def packed(text):
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("x.xml", text)
    return archive.getvalue()


ENTITIES = (b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "x">'
            + b"".join(b'<!ENTITY b%d "%s">' % (k, b"&b%d;" % (k - 1) * 10) for k in range(1, 9))
            + b"]><a>&b8;</a>")
REJECTED = {
    "cyclic: 'A'": document(integer("A", "<pValue>A</pValue>")),
    "cyclic": document(integer("A", "<pValue>B</pValue>") + integer("B", "<pValue>A</pValue>")),
    "cyclic: 'R2'": document(REGISTER.replace('"R"', '"R2"').replace(
        "<Address>0x10000</Address>", "<pAddress>R2</pAddress>")
        + integer("A", "<pValue>R2</pValue>")),
    "cyclic: 'A' follows": document(knife("V0", ["A"])),
    "chain of more than 100": chain(102),
    "a formula of 2001": document(knife("-" * 2000 + "1")),
    "elements in each other": document("<Group>" * 200 + "</Group>" * 200),
    "document type": ENTITIES,
    "follows from more than": doubling(30),
    "more than 16 MB": packed(bytes(17 << 20)),
    "broken: ": b"<a>",
    "broken archive": b"PK\3\4" + bytes(100),
}


@pytest.mark.parametrize("said", REJECTED)
def test_what_crashes_others_is_rejected(said):
    with pytest.raises(DeviceError, match=said):
        check_xml(REJECTED[said])


def test_what_is_right_is_accepted():
    """Limits that follow from each other are no circle: Width and OffsetX have them everywhere."""
    check_xml(genicam_xml())
    check_xml(packed(genicam_xml()))
    check_xml(document(integer("A", "<pValue>R</pValue><pMax>B</pMax>")
                       + integer("B", "<pValue>R</pValue><pMax>A</pMax><pSelected>A</pSelected>")))


_OPEN = """
import sys
from devices import device
from ncdc_host.client.devices import open_device
from ncdc_host.client.errors import DeviceError
from ncdc_host.device.emulated import Announcer
from ncdc_spec.protocols import gvcp
with device() as one:
    announcer = Announcer([one])
    xml, url = sys.stdin.buffer.read(), gvcp.register("FirstUrl")
    shown, memory = [xml, *map(str.encode, sys.argv[1:])], one.agent._memory
    def swapped(address, count, peer=None):
        if address == gvcp.XML_BASE:        # a read begins
            one.agent._xml = shown.pop(0) if shown else xml
            one.agent._xml += b" " * (len(xml) + -len(xml) % 4 - len(one.agent._xml))
        return memory(address, count, peer)
    one.agent._memory, one.agent._xml = swapped, xml + bytes(-len(xml) % 4)
    one.agent._texts[url.address] = (
        f"Local:x.xml;{gvcp.XML_BASE:X};{len(xml):X}".encode().ljust(512, b"\\0"))
    try:
        with open_device(f"gige://{one.options.address}", monitor=True) as opened:
            print(opened.names(), opened.features().keys())
    except DeviceError as error:
        print(error)
    announcer.close()
"""


def opened(xml, *later):
    """What a process says that opens a device of this XML, or of another one at a later read."""
    done = subprocess.run([sys.executable, "-c", _OPEN, *map(bytes.decode, later)], input=xml,
                          capture_output=True, timeout=60,
                          env={"PYTHONPATH": ":".join(sys.path), "PATH": "/usr/bin:/bin"})
    assert done.returncode == 0, done.stderr.decode()[-500:]
    return done.stdout.decode()


@pytest.mark.longer
def test_a_cyclic_device_does_not_end_the_client():
    assert "cyclic" in opened(REJECTED["cyclic"])


@pytest.mark.longer
def test_xml_that_is_swapped_after_the_check_does_not_end_the_client():
    good = chain(50)
    assert "'A'" in opened(good, good)
    assert "cyclic" in opened(good, REJECTED["cyclic"])


@pytest.mark.longer
def test_viva_survives_what_is_at_the_limits():
    for xml in (chain(100), document(knife("-" * 1999 + "1")), document(
            knife("(" * 999 + "1" + ")" * 999)), document(knife("1?1:" * 499 + "1"))):
        assert "'A'" in opened(xml)


def test_a_large_xml_is_not_even_read(monkeypatch):
    with device() as one:
        url = gvcp.register("FirstUrl")
        one.agent._texts[url.address] = (f"Local:x.xml;{gvcp.XML_BASE:X};"
                                         f"{xml_check.XML_BYTES_MAX + 1:X}").encode().ljust(512,
                                                                                            b"\0")
        with pytest.raises(DeviceError, match="16777217 bytes, 16777216 is the limit"):
            open_device(f"gige://{one.options.address}")


