"""A native port of LiteDRAM at an instance of our Verilog."""

from migen import Signal

__all__ = ["native_port"]

_ANY_ADDRESS_BITS = 32          # of our byte addresses


def native_port(module, port, prefix):
    """Connections of an Instance in the Migen ``module``: its port ``prefix`` and LiteDRAM's."""
    address = Signal(_ANY_ADDRESS_BITS - (port.data_width // 8 - 1).bit_length())
    # The bridges never hold back a word that was read.
    module.comb += [port.cmd.addr.eq(address), port.rdata.ready.eq(1)]
    return {
        f"o_{prefix}cmd_valid": port.cmd.valid, f"i_{prefix}cmd_ready": port.cmd.ready,
        f"o_{prefix}cmd_we": port.cmd.we, f"o_{prefix}cmd_addr": address,
        f"o_{prefix}wdata_valid": port.wdata.valid, f"i_{prefix}wdata_ready": port.wdata.ready,
        f"o_{prefix}wdata_data": port.wdata.data, f"o_{prefix}wdata_we": port.wdata.we,
        f"i_{prefix}rdata_valid": port.rdata.valid, f"i_{prefix}rdata_data": port.rdata.data}
