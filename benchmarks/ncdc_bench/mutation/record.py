"""The exact results of the benches on the designs as they are, in a file next to the benches.

    python -m ncdc_bench.mutation.record [DESIGN...]

A mutant that changes a clock of a frame or a counter is found. So the same change of the gateware
must fail a test: that compares the benches' results with this record.
"""

import json
import sys

from ncdc_bench.mutation.designs import PlayedBench, designs
from ncdc_bench.mutation.netlist import ROOT
from ncdc_hdl.export.verilog import module_verilog

__all__ = ["RECORD", "RENEW", "main", "reports_of"]

RECORD = ROOT / "tests" / "support" / "mutation" / "results.json"
RENEW = "python -m ncdc_bench.mutation.record DESIGN"


def reports_of(bench, verilog):
    """What each simulation of a :class:`PlayedBench` measured, see :attr:`Transcript.report`."""
    transcripts = []
    bench.run(verilog, transcripts)
    return [one.report for one in transcripts]


def main(names=()):
    """Run all benches that are played, or those of the designs ``names``, and write the record."""
    before = json.loads(RECORD.read_text()) if names else {}
    found = {}
    for name, design in designs().items():
        played = [bench for bench in design.benches if isinstance(bench, PlayedBench)]
        if names and name not in names:
            found |= {name: before[name]} if name in before else {}
        elif played:
            verilog = module_verilog(design.make(), design.top)
            found[name] = {bench.name: reports_of(bench, verilog) for bench in played}
    RECORD.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
