"""View of a system for a host that uses Table I: its registers and its pictures."""

from dataclasses import dataclass

from ncdc_spec.frames import output_format
from ncdc_spec.pixel_formats import raw_format

__all__ = ["SystemView"]


@dataclass(frozen=True)
class SystemView:
    """Registers and sizes from which the gateware answers a host.

    Parameters
    ----------
    addresses : dict
        Word address of each register of the system, by name.
    corrected : (int, int)
        Width and height of a corrected picture; (0, 0) if none is in memory.
    raw_formation, corrected_formation : int
        Bytes of Table II; in the raw one bit 0 and bit 1 change with an odd corner of the window.
    corrected_pixel : int
        Bytes of a corrected pixel.
    reader : int
        Number of its reader of the frame stores.
    clock_mhz : int
        Clock of the system in MHz.
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
        """View of a :class:`ncdc_hdl.system.System`."""
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
