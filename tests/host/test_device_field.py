"""The part of the sensor that an emulated device's raw frames show: features, words, registers."""

import pytest

from devices import SIZE, device, small_lens
from ncdc_host.client.devices import open_device
from ncdc_host.client.table import Connection
from ncdc_spec.errors import InputError
from ncdc_spec.protocols.features import feature, system_word
from ncdc_spec.sensors import mt9p031

FEATURES = ("SensorWidth", "SensorHeight", "DecimationHorizontal", "DecimationVertical",
            "FieldLeft", "FieldTop")


def read(one):
    """The features by Table I, and the sensor's window registers."""
    with Connection(one.options.address, one.table.port) as user:
        words = {name: user.read(feature(name).table[0]) for name in FEATURES}
        registers = [user.read(address) for address in (
            mt9p031.COLUMN_START, mt9p031.COLUMN_SIZE, mt9p031.ROW_MODE, mt9p031.COLUMN_MODE)]
        user.write(system_word("DECIMATION_X"), 2)
        assert user.read(system_word("DECIMATION_X")) == words["DecimationHorizontal"]
        # A window of raw frames is one of the sensor.
        for name, value in (("SOURCE", 0), ("WIDTH", 32), ("OFFSET_X", 8)):
            assert user.write(system_word(name), value) == value
        registers += [user.read(mt9p031.COLUMN_START), user.read(mt9p031.COLUMN_SIZE)]
    return list(words.values()), registers


def test_a_whole_field():
    with device([small_lens(bayer="GRBG")], field="256x192+1000+700") as one:
        words, registers = read(one)
    # Of 4, it bins 4, from a multiple of 8 on.
    assert words == [2592, 1944, 4, 4, 1000, 698]
    assert registers == [16 + 1000, 4 * SIZE[0] - 1, 0x33, 0x33, 16 + 1000 + 4 * 8, 4 * 32 - 1]


def test_a_window_in_the_middle():
    with device([small_lens(bayer="GRBG")]) as one:
        words, registers = read(one)
    assert words == [2592, 1944, 1, 1, (2592 - SIZE[0]) // 2, (1944 - SIZE[1]) // 2]
    assert registers == [16 + words[4], SIZE[0] - 1, 0, 0, 16 + words[4] + 8, 31]


def test_a_client_sees_it_as_features():
    with device([small_lens(bayer="GRBG")], field="128x96+0+0") as one:
        with open_device(f"gige://{one.options.address}") as client:
            assert [client.get(name) for name in FEATURES] == [2592, 1944, 2, 2, 0, 2]
            with pytest.raises(Exception, match="(?i)read|access"):
                client.set("DecimationHorizontal", 1)


def test_a_part_that_raw_frames_cannot_show():
    with pytest.raises(InputError, match="the field is 100x100, raw frames of 64x48 show 64x48, "):
        device([small_lens()], field="100x100")
