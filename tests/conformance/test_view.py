"""Views of a device on a network: one list of angles for emulated device and firmware."""

from dataclasses import replace

import numpy as np
import pytest

from devices import NARROW, device, view_lens
from firmware_wire import TcpUser, Wire
from gvcp_client import PEER, Client
from ncdc_host.client.table import TableDevice
from ncdc_spec.errors import InputError
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.features import VIEW_FEATURES, feature, system_word
from ncdc_spec.protocols.table_one import RATE, READ, VIEW, WRITE
from ncdc_spec.registers.register_map import CTRL_COMMIT, STATUS_COMMITTED, registers
from ncdc_spec.view_matrix import LIMITS, Angles, PlaneCamera

LENS = view_lens(focal=NARROW)
PLANE = PlaneCamera.of(LENS)
ANGLES = tuple(name.capitalize() for name in LIMITS)
LOWS, HIGHS = np.array([(feature(name).low, feature(name).high) for name in ANGLES]).T
AT = {one.name: one.address
      for one in registers(LENS.hidden_neurons, LENS.formats, LENS.nodes, view=True)}
OFF_BY = 1      # of a register's numbers: both sides compute in 64 bits, in another order


def cases():
    """Numbers of Pan, Tilt, Roll and Zoom: corners, quarters of a turn, and random ones."""
    rng = np.random.default_rng(46)
    ends = np.array(np.meshgrid(*np.stack([LOWS, HIGHS], 1))).reshape(4, -1).T
    quarters = [(0, 0, roll, 1000) for roll in (-18000, -9000, -4500, 4500, 9000, 18000)]
    return [*ends.tolist(), *quarters, *rng.integers(LOWS, HIGHS + 1, (80, 4)).tolist()]


def matrix_of(numbers):
    """The nine registers that the specification has for them; None if they do not fit."""
    angles = Angles(**{name.lower(): number / feature(name).scale[1]
                       for name, number in zip(ANGLES, numbers)})
    try:
        return PLANE.looking(angles).matrix
    except InputError:
        return None


@pytest.fixture
def wire(wire_firmware):
    with Wire(wire_firmware) as opened:
        opened.take_camera(LENS)
        opened.client = Client(lambda data: opened.datagram(data, PEER[1], PEER[0]))
        opened.client.control()
        yield opened


def corrector(name):
    """Address of a register of the corrector for GVCP."""
    return gvcp.CORRECTOR_BASE + 4 * AT[name]


def test_matrices_of_the_firmware_are_those_of_the_specification(wire):
    equal = rejected = 0
    for numbers in cases():
        wire.put(AT["STATUS"], STATUS_COMMITTED)        # the set is written once, with all four
        for _ in range(2):      # with the others of the case before, one may not fit alone
            straight = wire.client.set(Pan=0, Tilt=0, Roll=0, Zoom=1000)
        assert straight == [gvcp.SUCCESS] * 4
        answers = wire.client.set(**{name: number & 0xFFFFFFFF
                                     for name, number in zip(ANGLES, numbers)})
        before = len(wire.commits)
        wire.put(AT["STATUS"], 0)
        wire.wait(5)
        found, = wire.commits[before:]
        reached = [number if answer == gvcp.SUCCESS else default for number, answer, default in
                   zip(numbers, answers, (0, 0, 0, 1000))]
        # Each number is written alone: one that would not fit with those before it is rejected.
        tried = [0, 0, 0, 1000]
        for k, (number, answer) in enumerate(zip(numbers, answers)):
            fits = matrix_of([*tried[:k], number, *tried[k + 1:]]) is not None
            assert answer == (gvcp.SUCCESS if fits else gvcp.INVALID_PARAMETER)
            tried[k] = number if fits else tried[k]
            rejected += not fits
        differences = np.abs(np.subtract(found, matrix_of(reached)))
        assert differences.max() <= OFF_BY, numbers
        equal += not differences.any()
    assert equal >= 0.99 * len(cases()) and rejected


def test_the_emulated_device_rejects_the_same(wire):
    with device([LENS]) as one:
        emulated = Client(lambda data: one.agent.answers(data, PEER))
        emulated.control()
        for numbers in cases()[::4]:
            words = {name: number & 0xFFFFFFFF for name, number in zip(ANGLES, numbers)}
            assert emulated.set(**words) == wire.client.set(**words)
            for known in VIEW_FEATURES:
                assert emulated.get(known.name) == wire.client.get(known.name)


def test_table_one_has_the_same_view(wire):
    user = TcpUser(wire, 40_000)
    assert user.connect()
    with device([LENS]) as one, TableDevice(one.options.address, one.table.port) as client:
        emulated = Client(lambda data: one.agent.answers(data, PEER))
        for name, value in (("Pan", -90.0), ("Tilt", 12.34), ("Roll", -179.99), ("Zoom", 2.5)):
            assert client.set(name, value) == pytest.approx(value)
            word = round(value * feature(name).scale[1]) & 0xFFFF
            assert user.ask(WRITE, system_word(name.upper()), word) == word
            assert emulated.get(name) == wire.client.get(name)
            assert emulated.get(name) & 0xFFFF == word
        assert client.get("ViewFocal") == NARROW
    assert user.ask(READ, system_word("ABILITIES")) == RATE | VIEW
    assert user.ask(WRITE, system_word("PAN"), 9001) == 0xFFFF & -9000
    assert user.ask(READ, system_word("VIEW_FOCAL_UPPER")) == 3
    assert user.ask(READ, system_word("VIEW_FOCAL_LOWER")) == 200_000 - (3 << 16)


def test_a_lens_of_a_client_is_not_committed_by_a_view(wire):
    assert wire.client.write(corrector("VALID_BANK"), 1) == gvcp.SUCCESS
    assert wire.client.set(Pan=500) == [gvcp.SUCCESS]
    wire.wait(20)
    assert not wire.commits
    assert wire.client.write(corrector("CTRL"), CTRL_COMMIT) == gvcp.SUCCESS
    wire.wait(5)
    theirs, ours = wire.commits         # the second one has the new lens's camera
    assert theirs == (0,) * 9 and ours == matrix_of((500, 0, 0, 1000))
    # What a client that is gone has not committed holds back no view.
    wire.client.write(corrector("VALID_BANK"), 0)
    wire.client.set(Pan=600)
    wire.client.write(gvcp.register("ControlPrivilege").address, 0)
    wire.wait(5)
    assert len(wire.commits) == 3


def test_the_view_has_the_camera_of_a_lens_that_is_loaded(wire):
    wire.client.set(Pan=2000)
    for lens, view in ((view_lens(focal=70.5), Angles(pan=20)),
                       (replace(LENS, provenance={}), Angles())):
        wire.wait(5)
        wire.take_camera(lens)
        assert wire.client.write(corrector("CTRL"), CTRL_COMMIT) == gvcp.SUCCESS
        wire.wait(5)
        shown = PlaneCamera.of(lens) if lens.provenance else PLANE
        assert wire.commits[-1] == shown.looking(view).matrix
        assert wire.client.get("ViewFocal") == (7050 if lens.provenance else 0)
        assert wire.client.get("Pan") == 2000


def test_a_lens_that_cannot_look_so_far_is_seen_straight_on(wire):
    assert wire.client.set(Pan=8900) == [gvcp.SUCCESS]
    wire.wait(5)
    lens = view_lens(focal=4 * NARROW)
    wire.take_camera(lens)
    assert wire.client.write(corrector("CTRL"), CTRL_COMMIT) == gvcp.SUCCESS
    wire.wait(5)
    assert wire.commits[-1] == PlaneCamera.of(lens).looking(Angles()).matrix
    assert wire.client.get("Pan") == 0
    assert wire.client.set(Tilt=100) == [gvcp.SUCCESS]


def test_a_client_waits_for_the_commit_of_a_view(wire):
    wire.put(AT["STATUS"], STATUS_COMMITTED)
    data = gvcp.command_packet(gvcp.WRITEREG, 900, corrector("VALID_BANK").to_bytes(4, "big")
                               + (1).to_bytes(4, "big"))
    assert wire.datagram(data, PEER[1], PEER[0]) == []
    assert wire.peek(AT["VALID_BANK"]) == 0
    wire.put(AT["STATUS"], 0)
    wire.wait(5)
    assert wire.peek(AT["VALID_BANK"]) == 1
