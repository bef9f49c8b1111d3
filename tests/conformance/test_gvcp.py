"""One list of requests, and the same answers from every device that speaks GVCP."""

from devices import NARROW, device, view_lens
from firmware_wire import Wire
from gvcp_requests import PEERS, requests
from ncdc_spec.protocols import gvcp

REQUESTS = requests()


def emulated():
    """Answers of the emulated device, one list a request."""
    with device([view_lens(focal=NARROW)]) as one:
        return [one.agent.answers(request.data, PEERS[request.peer]) for request in REQUESTS]


def firmware(program):
    """Answers of the firmware."""
    with Wire(program) as wire:
        wire.take_camera(view_lens(focal=NARROW))
        return [wire.datagram(request.data, PEERS[request.peer][1], PEERS[request.peer][0])
                for request in REQUESTS]


def shown(request, answers):
    """What is compared of the answers to a request."""
    parts = [gvcp.parse_acknowledge(answer) for answer in answers]
    if request.whole:
        return [(hex(status), code, number, rest.hex()) for status, code, number, rest in parts]
    return [(hex(status), code, number, len(rest)) for status, code, number, rest in parts]


def differences(one, other):
    """Requests that two devices answer differently, with both answers."""
    return [(request.name, request.peer, *pair) for request, *pair in zip(
        REQUESTS, *([shown(request, answers) for request, answers in zip(REQUESTS, found)]
                    for found in (one, other))) if pair[0] != pair[1]]


def test_there_are_enough():
    assert len(REQUESTS) >= 300


def test_firmware_and_emulated_device_answer_alike(wire_firmware, monkeypatch):
    theirs = firmware(wire_firmware)
    assert differences(emulated(), theirs) == []
    # Each planted difference is seen.
    for name, value, asked in (
            ("REGISTERS_MAX", gvcp.REGISTERS_MAX - 1, "read 135 registers"),
            ("HEARTBEAT_MAX_MS", 30_001, "read HeartbeatTimeout"),
            ("WRITE_PROTECT", gvcp.ACCESS_DENIED, "write Version 0x0")):
        with monkeypatch.context() as planted:
            planted.setattr(gvcp, name, value)
            assert asked in [found[0] for found in differences(emulated(), theirs)]
