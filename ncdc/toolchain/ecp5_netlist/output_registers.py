"""Output registers of ECP5 block RAMs, which Yosys leaves outside the RAM."""

from ncdc.toolchain.ecp5_netlist.cells import (
    Wires,
    enable_of,
    flip_flop_without_reset,
    of_type,
)

__all__ = ["absorb_output_registers"]


def absorb_output_registers(netlist, top):
    """Move registers at the outputs of a block RAM into it, in a JSON netlist of ``synth_ecp5``.

    A RAM's output comes 4.3 ns after the clock, that of its output register much earlier. Yosys
    does not use that register; vendors' tools do. A RAM is changed if every used output feeds one
    flip-flop and nothing else, of the RAM's own clock, without reset and of one common enable. The
    function stays the same: OCE alone enables the register, CE the RAM before it.

    Parameters
    ----------
    netlist : dict
        Parsed; changed in place.
    top : str
        Name of the flat top module.

    Returns
    -------
    int
        Flip-flops that became part of a RAM.
    """
    module = netlist["modules"][top]
    cells = module["cells"]
    wires = Wires.of(module)
    absorbed = 0
    for ram in of_type(module, "DP16KD"):
        for data, port in _reads(ram):
            outputs = {output: bits[0] for output, bits in ram["connections"].items()
                       if output.startswith(data) and bits and wires.users[bits[0]]}
            after = {output: wires.readers.get(bit) for output, bit in outputs.items()}
            if not outputs or not all(
                    reader and wires.users[outputs[output]] == 1 and reader[1] == "DI"
                    and flip_flop_without_reset(cells[reader[0]])
                    and cells[reader[0]]["connections"]["CLK"] == ram["connections"][f"CLK{port}"]
                    for output, reader in after.items()):
                continue
            enables = {enable_of(cells[name]) for name, _ in after.values()}
            if len(enables) > 1:
                continue
            for output, (name, _) in after.items():
                ram["connections"][output] = cells.pop(name)["connections"]["Q"]
            for side in "AB" if data == "DO" else port:
                ram["parameters"][f"REGMODE_{side}"] = "OUTREG"
                ram["connections"][f"OCE{side}"] = list(enables)
            absorbed += len(after)
    return absorbed


def _reads(ram):
    """Prefix of the outputs and letter of the port of each read.

    At 36 bits port B reads to all outputs.
    """
    wide = int(ram["parameters"]["DATA_WIDTH_B"], 2) == 36
    return [("DO", "B")] if wide else [("DOA", "A"), ("DOB", "B")]
