"""Parts of the corrector alone, each with the stimulus of its own test.

The lowest bits of products, or the highest ones of sizes, hardly reach a pixel of a small frame.
"""


from mutation.core import HARDWARE, largest
from mutation.core import make as make_corrector
from ncdc_bench.mutation.designs import Design, PlayedBench
from ncdc_hdl.avalon.read_fence import ReadFence
from ncdc_hdl.backend.packer import Packer
from ncdc_hdl.frontend.strips import Strips
from simulations.traces import Recorded
from units.checks import check_checks
from units.colours import check_colour
from units.fences import check_read_fence
from units.neurons import check_hidden_neuron, check_output_neuron
from units.packers import check_packer
from units.products import check_product
from units.registers import check_registers
from units.row_gates import check_row_gate
from units.strips import check_strips
from units.tables import check_view_table
from units.windows import check_window_address
from units.writers import check_burst_writer

__all__ = ["DESIGN"]

_SIZES = (40, 24), (8, 8), (4096, 2730), (1365, 4096), (2049, 2047)
_HEIGHTS = 30, 8, 4096, 2731, 3999, 1365, 513, 2048
_PICTURES = (*((8 + 5 * k % 37, 2 + k % 5) for k in range(24)), (1365, 2), (2731, 2), (1400, 2),
             (2000, 2), (8, 260))
_ORDERS = ((8, 8, 0), (40, 9, 32), (65, 9, 64), (33, 20, 32), (100, 8, 96), (2731, 2, 0),
           (1400, 2, 992), (8, 520, 0))


def _hidden(dut):
    check_hidden_neuron(dut, largest().network_formats)


def _output(dut):
    check_output_neuron(dut, largest().network_formats)


def _windows(dut):
    check_window_address(dut, _SIZES, ((0, 0), (.3, .7), (0, .5), (.5, 0), (.2, .2)), 400)


def _gates(dut):
    check_row_gate(dut, _HEIGHTS)


def _strips(dut):
    check_strips(dut, _ORDERS, (0, .3, 0, .5, .1, 0, 0, 0))


def _packers(dut):
    check_packer(dut, _PICTURES)


def units():
    """Each part, as the corrector has it, with its check, by name."""
    corrector = make_corrector()
    nodes = corrector.backmap.network_at_nodes
    divider = nodes.transform.reciprocal
    hidden, output = nodes.hidden.units[0], nodes.output.outputs[0]
    burst = corrector.fetch.fills.burst
    product = make_corrector().backmap.network_at_nodes.hidden.units[0].products[0]
    # Products alone first: of equal modules the first instance is changed.
    return {"slope": (divider.slope, check_product), "curve": (divider.curve, check_product),
            "divide": (nodes.transform.divide, check_product),
            "normalise": (nodes.transform.normalise, check_product),
            "product": (product, check_product),
            "hidden_neuron": (hidden, _hidden), "output_neuron": (output, _output),
            "window": (corrector.window, _windows), "row_gate": (corrector.row_gate, _gates),
            "checks": (corrector.checks, check_checks), "strips": (Strips(1), _strips),
            "packer": (Packer(HARDWARE.data_width, placed=True), _packers),
            "read_fence": (ReadFence(HARDWARE.data_width, burst, shortest=burst),
                           check_read_fence),
            "registers": (corrector.registers, check_registers),
            "table": (corrector.table, check_view_table),
            "colour": (corrector.interpolator.colours[0], check_colour),
            "writer": (corrector.writer, check_burst_writer)}


_RECORDED = Recorded(units, "units")
DESIGN = Design("units", "units", _RECORDED.make, (PlayedBench("parts", _RECORDED.parts),), bare=1)
