"""The Python driver over a serial port, with a port that answers as the model of the link."""

import importlib.util
from importlib.resources import files

import pytest

from ncdc_spec.protocols.serial_link import BAD, READ, READ_DONE, WRITE_DONE, crc8


def backends():
    path = files("ncdc_hdl.export.drivers") / "host" / "ncdc_backends.py"
    spec = importlib.util.spec_from_file_location("ncdc_backends", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Port:
    """Answers requests out of ``words``. Of the first ``corrupted`` answers a bit is wrong, next
    ``lost`` never come."""

    def __init__(self, corrupted=0, lost=0):
        self.words, self.answer, self.requests = {}, b"", 0
        self.corrupted, self.lost = corrupted, lost

    def write(self, request):
        self.requests += 1
        assert crc8(request) == 0
        address = int.from_bytes(request[1:3], "big")
        if request[0] == READ:
            answer = bytes([READ_DONE]) + self.words.get(address, 0).to_bytes(4, "big")
        else:
            self.words[address] = int.from_bytes(request[3:7], "big")
            answer = bytes([WRITE_DONE])
        answer += bytes([crc8(answer)])
        if self.corrupted:
            self.corrupted -= 1
            answer = bytes([answer[0] ^ 4]) + answer[1:]
        elif self.lost:
            self.lost -= 1
            answer = b""
        self.answer += answer

    def read(self, size):
        given, self.answer = self.answer[:size], self.answer[size:]
        return given


def test_words_come_back():
    port = Port()
    read, write = backends().Serial(port)
    write(4 * 0x4042, 0xFEDCBA98)
    write(0, 7)
    assert port.words == {0x4042: 0xFEDCBA98, 0: 7}
    assert (read(4 * 0x4042), read(0), read(4)) == (0xFEDCBA98, 7, 0)
    assert port.requests == 5


@pytest.mark.parametrize("corrupted,lost", [(1, 0), (0, 2), (1, 1)])
def test_a_wrong_or_missing_answer_is_asked_for_again(corrupted, lost):
    port = Port(corrupted, lost)
    port.words[3] = 99
    read, _ = backends().Serial(port, pause=0)
    assert read(12) == 99 and port.requests == 1 + corrupted + lost


def test_a_port_without_a_board_is_reported():
    class Rejects(Port):
        def write(self, request):
            self.answer += bytes([BAD, crc8(bytes([BAD]))])

    for port in (Port(lost=3), Rejects()):
        with pytest.raises(OSError, match="no right answer"):
            backends().Serial(port, pause=0).read(0)
