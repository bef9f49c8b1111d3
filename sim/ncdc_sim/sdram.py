"""The SDRAM controller's Verilog on random traffic, with the chip's model at its pins."""

from dataclasses import dataclass
from fractions import Fraction

from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import HDL, build_bench, command_of
from ncdc_sim.tools import SimulationError
from ncdc_sim.transcript import transcribed

__all__ = ["ALONE", "ANYWHERE", "CORRECTOR", "Host", "ONWARDS", "SDRAM_CONTROLLER", "SILENT",
           "chip_parameters", "run_sdram", "sdram_results"]

SDRAM_CONTROLLER = "sdram_controller"
"""Name of the controller's module."""

# What a host of ``hdl/sdram_bench.v`` does.
SILENT, ANYWHERE, ONWARDS, CORRECTOR = range(4)
ALONE = 255     # a gap: the next command is given when the one before it is over

_ROW_BITS = 3   # bits of a row's number that distinguish stored rows


@dataclass(frozen=True)
class Host:
    """Traffic of a host: its kind; how many of 256 clocks pass without a command or a word, or
    :data:`ALONE`; minimum and maximum words of a burst."""
    kind: int = ANYWHERE
    gap: int = 100
    min_words: int = 1
    max_words: int = 8


def chip_parameters(chip, clock_hz, **other):
    """Parameters of ``hdl/sdram_chip.v`` for a chip at a clock: its times in ps, unrounded."""
    def ps(time):
        return int(1000 * Fraction(str(time)))

    cas = dict(chip.cas)
    parameters = {
        "DATA": chip.data_bits, "ROW": chip.row_bits, "COLUMN": chip.column_bits,
        "PERIOD": int(Fraction(10**12) / Fraction(clock_hz)), "RCD": ps(chip.rcd),
        "RP": ps(chip.rp), "RAS": ps(chip.ras), "RAS_MAX": ps(chip.ras_max), "RC": ps(chip.rc),
        "RFC": ps(chip.rfc), "WR": ps(chip.wr), "WR_CLOCKS": chip.wr_clocks, "RRD": ps(chip.rrd),
        "MRD": ps(chip.mrd), "MRD_CLOCKS": chip.mrd_clocks,
        "CAS2": ps(cas.get(2, 1000)), "CAS3": ps(cas.get(3, 1000)),
        "PAUSE": ps(1000 * chip.pause), "REFRESHES": 2, "REFRESH_GAP": ps(chip.refresh),
        "REFRESH_CYCLES": chip.refresh_cycles}
    return parameters | other


def run_sdram(controller, hosts, *, clocks, clock_hz, simulator="verilator", **settings):
    """Run an :class:`~ncdc_boards.sdram.controller.SdramController` for so many clocks.

    Parameters
    ----------
    controller : SdramController
    hosts : sequence of Host
        The readers, then the writer.
    clocks : int
        After the initialisation.
    clock_hz : number
        Clock with which the chip's times are checked.
    simulator : str
        One of ``ncdc_sim.tools.SIMULATORS``.
    settings
        ``seed``; ``resets``, mean clocks between two; ``times``, changed times of the chip's model
        in ps, by the names of its parameters; ``verilog``, the controller's text, made if absent;
        ``transcripts``, a list to which the run's transcript is added.

    Returns
    -------
    dict
        Numbers: ``violations``, ``wrong`` words, ``checked`` and ``unsure`` ones, ``port_errors``,
        ``refreshes``, ``refresh_most``, ``beats`` of data, ``resets``; clocks from a reset to
        ``ready``: ``ready_first``, and ``ready_longest`` of the later ones. Of each host
        ``words`` and ``longest`` (clocks from a command accepted alone to its last word).
        ``rules``: the set of rules violated.

    Raises
    ------
    SimulationError
        If it does not compile, or ends without a result.
    """
    mapping = controller.mapping
    parameters = chip_parameters(mapping.chip, clock_hz, STORED=_ROW_BITS, COPIES=1)
    defines = {"NCDC_READS": controller.count, "NCDC_DATA": mapping.data_width,
               "NCDC_BURST": mapping.max_burst, "NCDC_COLUMNS": mapping.column_bits,
               "NCDC_ROWS": mapping.chip.row_bits, "NCDC_BEATS": mapping.beats}
    names = ("sdram_chip.v", "avalon_checker.v", "digest.v", "sdram_bench.v")
    verilog = settings.get("verilog") or module_verilog(controller, SDRAM_CONTROLLER)
    sources = [("controller.v", verilog),
               ("sdram_dut.v", _dut(controller, parameters)),
               *((name, (HDL / name).read_text()) for name in names)]
    program = build_bench("sdram", "sdram_bench", sources, defines=defines, simulator=simulator,
                          optimise="-O2" if clocks > 300_000 else "-O0")
    plusargs = {"clocks": clocks, "seed": settings.get("seed", 1),
                "resets": settings.get("resets", 0)} | settings.get("times", {})
    plusargs |= {name: "".join(f"{getattr(host, field):02x}" for host in reversed(hosts))
                 for name, field in (("kind", "kind"), ("gap", "gap"), ("least", "min_words"),
                                     ("most", "max_words"))}
    found = sdram_results(program, plusargs, settings.get("transcripts"))
    for name in ("words", "longest"):
        found[name] = [found.pop(f"{name}{k}") for k in range(len(hosts))]
    return found


def sdram_results(program, plusargs, transcripts=None):
    """Numbers of a bench with the chip's model, and ``rules``, the set of rules violated.

    ``transcripts``: a list to which the run's transcript is added.
    """
    rules, found = set(), {}

    def hear(line):
        kind, *values = line.split() or [""]
        if kind == "SDRAM-VIOLATION":
            rules.add(values[0])
        elif kind == "AVALON-ERROR":
            rules.add(f"avalon {values[1]}")
        elif kind == "RESULT":
            found[values[0]] = int(values[1])

    transcribed([*command_of(program), *(f"+{name}={value}" for name, value in plusargs.items())],
                hear, transcripts)
    if not found:
        raise SimulationError("the simulation ended without a result")
    return found | {"rules": rules}


def _digest(mapping, reads):
    """Verilog of the hash of the controller's outputs, as far as they are valid."""
    data, chip = mapping.data_width, mapping.chip
    address = max(chip.row_bits, 11)
    outputs = [("ready", 1), ("cke", 1), ("cs_n", 1), ("dqm", chip.data_bits // 8),
               (f"cs_n ? {address + 5}'d0 : {{ba, a, ras_n, cas_n, we_n}}", address + 5),
               ("dq_oe", 1), (f"dq_oe ? dq_c : {chip.data_bits}'d0", chip.data_bits),
               ("write_waitrequest & write_write", 1), ("read_waitrequest & read_read", reads),
               ("read_readdatavalid", reads)]
    outputs += [(f"read_readdatavalid[{k}] ? read_readdata[{data * k} +: {data}] : {data}'d0", data)
                for k in range(reads)]
    bits = sum(width for _, width in outputs)
    values = ", ".join(text for text, _ in outputs)
    return (f"digest #(.WORDS({-(-bits // 32)})) digest (.clk(clk), .sum(trace), .value({{"
            f"{{{-bits % 32}{{1'b0}}}}, {values}}}));")


def _dut(controller, parameters):
    """Verilog of ``sdram_dut``: the controller, its ports as vectors, and the chip."""
    mapping, reads = controller.mapping, controller.count
    data, bits = mapping.data_width, mapping.max_burst.bit_length()
    lanes, chip = data // 8, mapping.chip
    ports = "".join(f"""
        .reads__{k}__address(read_address[{32 * k} +: 32]), .reads__{k}__read(read_read[{k}]),
        .reads__{k}__burstcount(read_burstcount[{bits * k} +: {bits}]),
        .reads__{k}__waitrequest(read_waitrequest[{k}]),
        .reads__{k}__readdata(read_readdata[{data * k} +: {data}]),
        .reads__{k}__readdatavalid(read_readdatavalid[{k}]),""" for k in range(reads))
    ports += "".join(f"\n        .write__{name}(write_{name})," for name in
                     ("address", "write", "burstcount", "writedata", "byteenable", "waitrequest"))
    names = ("cke", "cs_n", "ras_n", "cas_n", "we_n", "ba", "a", "dqm")
    pins = "".join(f".pins__{name}({name}), " for name in names)
    values = ", ".join(f".{name}({value})" for name, value in parameters.items())
    return f"""`timescale 1ns/1ps
module sdram_dut (
    input  wire clk, rst,
    input  wire [{32 * reads - 1}:0] read_address,
    input  wire [{reads - 1}:0] read_read,
    input  wire [{bits * reads - 1}:0] read_burstcount,
    output wire [{reads - 1}:0] read_waitrequest, read_readdatavalid,
    output wire [{data * reads - 1}:0] read_readdata,
    input  wire [31:0] write_address,
    input  wire write_write,
    input  wire [{bits - 1}:0] write_burstcount,
    input  wire [{data - 1}:0] write_writedata,
    input  wire [{lanes - 1}:0] write_byteenable,
    output wire write_waitrequest, ready,
    output wire [31:0] violations, refreshes, refresh_most, beats_read, beats_written,
    output wire [63:0] trace
);
    wire cke, cs_n, ras_n, cas_n, we_n, dq_oe, dq_drives;
    wire [1:0] ba;
    wire [{max(chip.row_bits, 11) - 1}:0] a;
    wire [{chip.data_bits // 8 - 1}:0] dqm;
    wire [{chip.data_bits - 1}:0] dq_c, dq_m;
    {_digest(mapping, reads)}
    {SDRAM_CONTROLLER} controller ({ports}
        {pins}
        .pins__dq_o(dq_c), .pins__dq_oe(dq_oe),
        .pins__dq_i(dq_drives ? dq_m : {{{chip.data_bits}{{1'b1}}}}),
        .clk(clk), .rst(rst), .ready(ready)
    );
    sdram_chip #({values}) chip (
        .clk(clk), .controller_rst(rst), .cke(cke), .cs_n(cs_n), .ras_n(ras_n), .cas_n(cas_n),
        .we_n(we_n), .ba(ba), .a(a), .dqm(dqm), .dq_i(dq_c), .dq_oe(dq_oe), .dq_o(dq_m),
        .dq_drives(dq_drives), .violations(violations), .refreshes(refreshes),
        .refresh_most(refresh_most), .beats_read(beats_read), .beats_written(beats_written)
    );
endmodule
"""
