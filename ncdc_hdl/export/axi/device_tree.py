"""The registers and frames of a module with AXI ports, for Linux's device tree."""

__all__ = ["device_tree"]

_FRAMES_MB = 64


def device_tree(module, register_bytes):
    """Text of ``<module>.dtsi``: an overlay of what the user's own device tree includes.

    Addresses are examples, each on a line that says so: those of the design's address editor count.
    """
    return f"""\
// {module} in Linux's device tree: registers and interrupt as a UIO device, and memory for frames
// that Linux keeps off. To be included into the board's own tree; boot with
//     uio_pdrv_genirq.of_id=generic-uio

/ {{
    reserved-memory {{
        #address-cells = <1>;
        #size-cells = <1>;
        ranges;

        ncdc_frames: ncdc-frames@10000000 {{
            reg = <0x10000000 {_FRAMES_MB << 20:#x}>;       // yours: where frames lie
            no-map;
        }};
    }};

    ncdc@43c00000 {{
        compatible = "generic-uio";
        reg = <0x43c00000 {register_bytes:#x}>;         // yours: of s_axi in the address editor
        interrupt-parent = <&intc>;
        interrupts = <0 29 4>;              // yours: the line that irq is on; 4: high level
    }};
}};
"""
