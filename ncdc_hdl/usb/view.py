"""What a system is to a host that speaks Table I: its registers and its pictures."""

from dataclasses import dataclass

from ncdc_spec.frames import output_format
from ncdc_spec.pixel_formats import raw_format

__all__ = ["SystemView"]


@dataclass(frozen=True)
class SystemView:
    """Where the gateware finds what it tells a host.

    Parameters
    ----------
    addresses : dict
        Word address of each register of the system, by name.
    corrected : (int, int)
        Width and height of a corrected picture; (0, 0) if none is in memory.
    raw_formation, corrected_formation : int
        Bytes of Table II; of the raw one bit 0 and bit 1 change with an odd window's corner.
    corrected_pixel : int
        Bytes of a corrected pixel.
    reader : int
        Which reader of the frame stores it is.
    clock_mhz : int
        Of the system's clock.
    """
    addresses: dict
    corrected: tuple
    raw_formation: int
    corrected_formation: int
    corrected_pixel: int
    reader: int
    clock_mhz: int

    @classmethod
    def of(cls, system, reader, clock_mhz):
        """Of a :class:`ncdc_hdl.system.System`."""
        geometry, hardware = system.descriptor.geometry, system.hardware
        table = (*system.corrector.registers.table, *system.table)
        sent = output_format(hardware.format).sent
        return cls({r.name: r.address for r in table},
                   (0, 0) if hardware.stream else geometry.corrected,
                   raw_format(geometry).mraw, sent.mraw, sent.pixel_bytes, reader, clock_mhz)

    @property
    def has_corrected(self):
        """Whether corrected pictures are in memory."""
        return self.corrected != (0, 0)
