"""The registers and frames of a module with AXI ports, for Linux's device tree."""

from dataclasses import dataclass

__all__ = ["ModuleResources", "device_tree"]


@dataclass(frozen=True)
class ModuleResources:
    """Addresses and interrupt of a module for Linux.

    Parameters
    ----------
    registers, register_bytes : int
    frames, frame_bytes : int
        Memory that Linux reserves for frames.
    interrupt : int
        Number among the shared interrupts of the controller.
    fixed : bool
        Whether the board decides all of it; else they are examples.
    """
    registers: int = 0x43C0_0000
    register_bytes: int = 1 << 16
    frames: int = 0x1000_0000
    frame_bytes: int = 64 << 20
    interrupt: int = 29
    fixed: bool = False


def device_tree(module, resources):
    """Text of ``<module>.dtsi``: an overlay that the user's own device tree includes.

    Example addresses are marked in their lines: those of the design's address editor
    are valid.
    """
    notes = ("addresses of frames", "the lightweight bridge", "f2h_irq0") if resources.fixed else (
        "yours: addresses of frames", "yours: s_axi in the address editor",
        "yours: the line that irq is on")
    return f"""\
// {module} in Linux's device tree: registers and interrupt as a UIO device, and memory for frames
// that Linux does not use. To be included into the board's own tree; boot with
//     uio_pdrv_genirq.of_id=generic-uio

/ {{
    reserved-memory {{
        #address-cells = <1>;
        #size-cells = <1>;
        ranges;

        ncdc_frames: ncdc-frames@{resources.frames:x} {{
            reg = <{resources.frames:#x} {resources.frame_bytes:#x}>;       // {notes[0]}
            no-map;
        }};
    }};

    ncdc@{resources.registers:x} {{
        compatible = "generic-uio";
        reg = <{resources.registers:#x} {resources.register_bytes:#x}>;         // {notes[1]}
        interrupt-parent = <&intc>;
        interrupts = <0 {resources.interrupt} 4>;              // {notes[2]}; 4: high level
    }};
}};
"""
