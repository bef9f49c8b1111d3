"""The benches of ``ncdc bench``, by name."""

from ncdc_bench.accuracy import command as accuracy
from ncdc_bench.calibration import command as calibration
from ncdc_bench.client import command as client
from ncdc_bench.cost import command as cost
from ncdc_bench.grid import command as grid
from ncdc_bench.lines import command as lines
from ncdc_bench.lot import command as lot
from ncdc_bench.model import command as model
from ncdc_bench.mutation import command as mutation
from ncdc_bench.network import command as network
from ncdc_bench.nodes import command as nodes
from ncdc_bench.photos import command as photos
from ncdc_bench.pictures import command as pictures
from ncdc_bench.synth import command as synth
from ncdc_bench.system import command as system
from ncdc_bench.tansig import command as tansig
from ncdc_bench.throughput import command as throughput
from ncdc_bench.truth import command as truth
from ncdc_bench.view import command as view
from ncdc_bench.window import command as window

__all__ = ["BENCHES"]

BENCHES = {"accuracy": accuracy, "calibration": calibration, "client": client, "cost": cost,
           "grid": grid, "lines": lines, "lot": lot, "model": model, "mutation": mutation,
           "network": network, "nodes": nodes, "photos": photos, "pictures": pictures,
           "synth": synth, "system": system, "tansig": tansig, "throughput": throughput,
           "truth": truth, "view": view, "window": window}
