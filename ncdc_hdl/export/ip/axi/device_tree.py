"""The registers and frames of a module with AXI ports, for Linux's device tree."""

from dataclasses import dataclass

__all__ = ["Place", "device_tree"]


@dataclass(frozen=True)
class Place:
    """Where Linux finds a module.

    Parameters
    ----------
    registers, register_bytes : int
    frames, frame_bytes : int
        Memory that Linux leaves to frames.
    interrupt : int
        Of the shared ones of the interrupt controller.
    fixed : bool
        Whether the board decides all of it; else they are examples.
    """
    registers: int = 0x43C0_0000
    register_bytes: int = 1 << 16
    frames: int = 0x1000_0000
    frame_bytes: int = 64 << 20
    interrupt: int = 29
    fixed: bool = False


def device_tree(module, place):
    """Text of ``<module>.dtsi``: an overlay of what the user's own device tree includes.

    Addresses that are examples are on a line that says so: those of the design's address editor
    count.
    """
    notes = ("where frames lie", "the lightweight bridge", "f2h_irq0") if place.fixed else (
        "yours: where frames lie", "yours: of s_axi in the address editor",
        "yours: the line that irq is on")
    return f"""\
// {module} in Linux's device tree: registers and interrupt as a UIO device, and memory for frames
// that Linux keeps off. To be included into the board's own tree; boot with
//     uio_pdrv_genirq.of_id=generic-uio

/ {{
    reserved-memory {{
        #address-cells = <1>;
        #size-cells = <1>;
        ranges;

        ncdc_frames: ncdc-frames@{place.frames:x} {{
            reg = <{place.frames:#x} {place.frame_bytes:#x}>;       // {notes[0]}
            no-map;
        }};
    }};

    ncdc@{place.registers:x} {{
        compatible = "generic-uio";
        reg = <{place.registers:#x} {place.register_bytes:#x}>;         // {notes[1]}
        interrupt-parent = <&intc>;
        interrupts = <0 {place.interrupt} 4>;              // {notes[2]}; 4: high level
    }};
}};
"""
