"""A client that knows docs/reference/protocols.md alone takes an emulated device's picture."""

import re
import socket
from pathlib import Path

from devices import SIZE, device
from ncdc_spec.protocols import gvcp, gvsp
from ncdc_spec.protocols.gvcp_tables import COMMANDS, STATUSES

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "protocols.md").read_text()


def rows(part, columns):
    """Cells of the rows with so many columns of a section of the page, without their head."""
    section = PAGE.partition(f"\n## {part}")[2].partition("\n## ")[0]
    found = [[cell.strip(" `") for cell in line.strip("|").split("|")]
             for line in section.splitlines() if re.match(r"\| *[`0-9]", line)]
    return [row for row in found if len(row) == columns]


def layouts():
    """{meaning: (byte, count)} of each packet of GVSP, by the order on the page."""
    found = []
    for at, count, meaning in rows("GVSP", 3):
        if int(at) in (0, 8):
            found.append({})
        found[-1][meaning.partition(":")[0].partition(",")[0]] = int(at), int(count)
    return found


class Stranger:
    """Commands by the numbers of the page."""

    def __init__(self, address):
        self._codes = {row[0]: int(row[1], 16) for row in rows("GVCP", 4)
                       if row[1].startswith("0x")}
        self._statuses = {int(row[0], 16): row[1] for row in rows("GVCP", 3)}
        self.addresses = {row[1]: int(row[0], 16) for row in rows("GVCP", 5) if row[0] != "0"}
        self.addresses |= {row[0]: int(row[1], 16) for row in rows("Features", 8)}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(5)
        self._socket.connect((address, int(re.search(r"## GVCP, UDP port (\d+)", PAGE)[1])))
        self.address, self._number = self._socket.getsockname()[0], 0

    def ask(self, name, payload=b""):
        self._number += 1
        code, number = (value.to_bytes(2, "big") for value in (self._codes[name], self._number))
        self._socket.send(b"\x42\x01" + code + len(payload).to_bytes(2, "big") + number + payload)
        answer = self._socket.recv(2000)
        assert answer[2:4] == (self._codes[name] + 1).to_bytes(2, "big") and answer[6:8] == number
        return self._statuses[int.from_bytes(answer[:2], "big")], answer[8:]

    def write(self, name, value):
        return self.ask("WRITEREG", self.addresses[name].to_bytes(4, "big")
                        + value.to_bytes(4, "big"))[0]


def test_a_stranger_takes_a_picture():
    leader_at = layouts()[1]
    with device() as one, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stream:
        client = Stranger(one.options.address)
        status, memory = client.ask("DISCOVERY")
        vendor = client.addresses["DeviceVendorName"]
        assert status == "SUCCESS" and memory[vendor:vendor + 5] == b"NCDC\0"
        assert client.write("Gain", 16) == "ACCESS_DENIED"
        stream.bind((client.address, 0))
        stream.settimeout(5)
        for name, value in (
                ("ControlPrivilege", 2), ("StreamPort", stream.getsockname()[1]),
                ("StreamAddress", int.from_bytes(socket.inet_aton(client.address), "big")),
                ("AcquisitionStart", 1)):
            assert client.write(name, value) == "SUCCESS", name
        picture, size = b"", None
        while True:
            packet = stream.recv(10_000)
            kind = packet[layouts()[0]["format"][0]]
            if kind == 1:
                fields = {name: int.from_bytes(packet[at:at + count], "big")
                          for name, (at, count) in leader_at.items()}
                picture, size = b"", (fields["width"], fields["height"])
            elif kind == 3:
                picture += packet[8:]
            elif size:
                break
        assert size == SIZE
        assert picture == bytes(one.camera.newest().data)
        assert client.write("AcquisitionStop", 1) == client.write("ControlPrivilege", 0) \
            == "SUCCESS"


def test_the_tables_are_complete():
    """Each number of the module is on the page, and the layouts have the bytes that are sent."""
    statuses = {name for name in gvcp.__all__ if isinstance(getattr(gvcp, name), int)
                and 0x8001 <= getattr(gvcp, name) <= 0x8FFF}
    assert {status.name for status in STATUSES} == statuses | {"SUCCESS"}
    assert {command.name for command in COMMANDS} == {
        "DISCOVERY", "FORCEIP", "PACKETRESEND", "READREG", "WRITEREG", "READMEM", "WRITEMEM"}
    force = next(command for command in COMMANDS if command.name == "FORCEIP")
    assert sum(count for count, _ in force.request) == gvcp.FORCE_IP.size
    for fields, packet in ((gvsp.LEADER_FIELDS, gvsp.leader(1, 0, _Format, (1, 1))),
                           (gvsp.TRAILER_FIELDS, gvsp.trailer(1, 2, 3))):
        assert sum(count for count, _ in gvsp.HEADER_FIELDS + fields) == len(packet)


class _Format:
    pfnc = 0
