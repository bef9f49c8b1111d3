"""Sizes of the parts of the system by Yosys, for Cyclone V and ECP5."""

import json
from collections import Counter
from pathlib import Path

from litex.gen.fhdl.verilog import convert
from migen import ClockDomain, Record

from ncdc.toolchain.flows import cyclone_v, plain_netlist
from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.avalon.native import NativeReader, NativeWriter
from ncdc_hdl.avalon.wishbone import WishboneAgent
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.link.packetiser import Packetiser
from ncdc_hdl.link.processor import ADDRESS_BITS
from ncdc_soc.core import SocCore
from ncdc_soc.mac import Mac, ModelPhy
from ncdc_soc.soc import soc_verilog
from ncdc_spec.hardware import Hardware

__all__ = ["sizes_of"]

_BITS, _BURST, _PENDING = 32, 16, 4
_VIEW = 100             # degrees of the lens
_BYTE = [(f"{side}_{name}", 8 if name == "data" else 1)
         for side in ("source", "sink") for name in ("valid", "ready", "data")]


def sizes_of(size, step):
    """Two rows for each part, for pictures of that size: ``part``, ``target`` ("cyclonev" or
    "ecp5"), ``alm`` (None for ECP5), ``lut``, ``ff``, ``dsp``, ``ram_blocks``.

    On ECP5 ``lut`` counts half slices: LUTs, carries, distributed RAM. Place and route is not run.
    Raises :class:`ncdc.toolchain.flows.SynthesisError` if a tool fails.
    """
    for part, top, text in _parts(trained(Lens(_VIEW, size))):
        step(part)
        found = cyclone_v(text, top)
        yield {"part": part, "target": "cyclonev", "alm": found["alm"], "lut": found["alut"],
               "ff": found["alm_ff"], "dsp": found["dsp"], "ram_blocks": found["m10k"]}
        yield {"part": part, "target": "ecp5"} | _ecp5(text, top)


def _parts(descriptor):
    """(name, top module, Verilog) of each part."""
    hardware = Hardware(bus="axi", format="BGR8")
    for name, component in (
            ("read bridge", NativeReader(_BITS, _BURST)),
            ("write bridge", NativeWriter(_BITS, _BURST, _PENDING)),
            ("register bridge", WishboneAgent(ADDRESS_BITS)),
            ("packetiser", Packetiser(_BITS))):
        yield name, "part", module_verilog(component, "part")
    yield "MAC with its frames", "mac", _mac()
    core = SocCore(descriptor, hardware)
    yield "processor", "VexRiscv", Path(soc_verilog(core).core).read_text()
    yield "camera, corrector, packetiser, bridges", "ncdc_core", module_verilog(core, "ncdc_core")


def _mac():
    """The MAC with a PHY of a byte per clock; its registers are pins."""
    pins = Record(_BYTE)
    phy = ModelPhy(pins)
    mac = Mac(phy)
    mac.submodules += phy
    mac.clock_domains.cd_sys = ClockDomain("sys")
    ios = {mac.cd_sys.clk, mac.cd_sys.rst}
    for record in (pins, mac.bus_rx, mac.bus_tx, mac.frames):
        ios |= set(record.flatten())
    for csr in mac.get_csrs():
        ios |= {getattr(csr, name) for name in ("storage", "status", "re", "we", "r", "w")
                if hasattr(csr, name)}
    return str(convert(mac, ios=ios, name="mac"))


def _ecp5(text, top):
    cells = Counter(cell["type"] for cell in
                    json.loads(plain_netlist(text, top))["modules"][top]["cells"].values())
    return {"alm": None, "lut": cells["LUT4"] + 2 * cells["CCU2C"] + 6 * cells["TRELLIS_DPR16X4"],
            "ff": cells["TRELLIS_FF"], "dsp": cells["MULT18X18D"], "ram_blocks": cells["DP16KD"]}
