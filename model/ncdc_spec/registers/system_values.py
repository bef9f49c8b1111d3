"""Values of a system's registers after a reset: sizes and addresses for one camera."""

from ncdc_spec.camera_port import CSI2, CameraPort
from ncdc_spec.frames import FrameAddresses, output_format, source_bytes, target_bytes
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.registers.system_map import Stores
from ncdc_spec.sensors.csi2 import DataType
from ncdc_spec.sensors.level import LINEAR
from ncdc_spec.white_balance import gains_word

__all__ = ["memory_bytes", "stores_for", "system_values"]

_ALIGN = 4096               # bytes; each buffer begins at a multiple of this
_CLOCK_LIMIT = 1_000_000    # 10 ms at 100 MHz: longer than any sensor's blanking between two rows
_I2C_QUARTER = 250          # 100 kHz at 100 MHz
_I2C_LIMIT = 2_500_000      # 25 ms at 100 MHz, as the SMBus specification has it


def stores_for(hardware, readers, screens=0):
    """:class:`Stores` of a system of ``hardware`` with so many ``readers`` by registers.

    Each store has a buffer for the writer, one for the newest frame, and one for each reader; the
    corrector reads raw frames too, and ``screens`` corrected ones.
    """
    return Stores(readers + 3, 0 if hardware.stream else readers + screens + 2, readers, screens)


def _aligned(value):
    return -(-value // _ALIGN) * _ALIGN


def _sizes(descriptor, hardware):
    """Pitch of raw frames, bytes of the buffers of a raw and of a corrected frame."""
    pitch = FrameAddresses.after_reset(descriptor.geometry, hardware.data_width).pitch
    return (pitch, _aligned(source_bytes(descriptor.geometry, pitch)),
            _aligned(target_bytes(descriptor.geometry, hardware.data_width,
                                  output_format(hardware.format))))


def memory_bytes(descriptor, hardware, stores):
    """Bytes that all buffers take, from byte address 0 on."""
    _, raw, corrected = _sizes(descriptor, hardware)
    return stores.raw * raw + stores.corrected * corrected


def system_values(descriptor, hardware, stores, camera=CameraPort()):
    """Register values after a reset, by name, of a system made for ``descriptor``'s ``camera``.

    The sensor is taken to send what is captured; raw buffers lie from byte address 0 on, those of
    corrected frames after them.
    """
    g = descriptor.geometry
    pitch, raw, corrected = _sizes(descriptor, hardware)
    width, height = g.distorted
    return {
        "SENT_WIDTH": width, "SENT_HEIGHT": height, "WINDOW_WIDTH": width, "WINDOW_HEIGHT": height,
        "CLOCK_LIMIT": _CLOCK_LIMIT, "RAW_PITCH": pitch, "RAW_BYTES": raw,
        "CORRECTED_BYTES": corrected,
        **{f"CURVE{k}": value for k, value in enumerate(LINEAR)},
        "CAPTURE_GAINS": gains_word(NO_RAW_GAINS),
        **({"CSI_TYPE": int(DataType.RAW10)} if camera.kind == CSI2 else {}),
        "I2C_QUARTER": _I2C_QUARTER, "I2C_LIMIT": _I2C_LIMIT,
        **{f"RAW{k}_BASE": k * raw for k in range(stores.raw)},
        **{f"CORRECTED{k}_BASE": stores.raw * raw + k * corrected
           for k in range(stores.corrected)},
    }
