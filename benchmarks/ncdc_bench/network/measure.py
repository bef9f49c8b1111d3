"""The simulated system on a network of its own: one row for each thing that clients do."""

import json
import re
import statistics
import sys
import tempfile
from pathlib import Path

import numpy as np

from ncdc_bench.client.measure import PEERS, still_photo
from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_model.correction import correct
from ncdc_sim.system.soc import ADDRESS, SocModel, SocRun
from ncdc_sim.tools import SimulationError
from ncdc_spec.protocols.gvcp import CORRECTOR_BASE
from ncdc_spec.registers.register_map import registers

__all__ = ["LOSS", "rows_of"]

LOSS = 50               # of a thousand packets of pictures
_MTU = 1500
_LINK = "a byte per clock, 100 MHz"
# The first exposure, and those that a client sets, of small pictures and of others. They are whole
# lines: the client counts lines, and must agree with the sensor's configuration.
_SMALL_EXPOSURES_US, _EXPOSURES_US = (100.0, 60.0, 200.0), (1000.0, 500.0, 2000.0)
_COMMANDS = 30
_SMALL = 320            # columns of a picture that comes faster than a client takes it
_VIEW, _OTHER_VIEW = 100, 80    # degrees of the two lenses


class _Bench:
    """One simulated system and the rows that it gives.

    Parameters
    ----------
    model : SocModel
    folder : Path
    """

    def __init__(self, model, folder):
        self.model, self.folder = model, folder
        self.count = 0
        self.exposures = _exposures(model.descriptor.geometry.corrected)
        small = model.descriptor.geometry.corrected[0] < _SMALL
        self.frames_during_commands = 12 if small else 6

    def _row(self, what, peer, **figures):
        width, height = self.model.descriptor.geometry.corrected
        return {"what": what, "peer": peer, "link": _LINK, "mtu": _MTU, "width": width,
                "height": height, "format": "BGR8", "frames": 0, "pixels_different": None,
                "megabytes_per_second": None, "underruns": None, "clocks_per_command": None,
                "most_clocks_per_command": None, "resent": None,
                "clocks_per_pixel": None, **figures}

    def ask(self, run, task):
        """The report on a task of :mod:`ncdc_bench.network.peer`."""
        return self.report(run, self.start(run, task))

    def report(self, run, process, timeout=900):
        """The report of a peer's process, once it has ended."""
        out, _ = process.communicate(timeout=timeout)
        if process.returncode:
            said = (self.folder / "peer.txt").read_text().splitlines()[-1:]
            raise SimulationError(f"a peer failed: {' '.join(said)}; the system said: "
                                  f"{run.screen[-500:]}")
        return json.loads(out.splitlines()[-1])

    def start(self, run, task):
        """The peer's process that works on a task."""
        with open(self.folder / "peer.txt", "w") as errors:
            return run.network.start([sys.executable, "-m", "ncdc_bench.network.peer",
                                      json.dumps(task)], stdout=-1, stderr=errors)

    def pictures(self, scheme, frames, changes=()):
        """A task: pictures by that scheme of URLs, in a folder of their own."""
        self.count += 1
        folder = self.folder / str(self.count)
        folder.mkdir()
        return {"do": "pictures", "url": f"{scheme}://{ADDRESS}", "folder": str(folder),
                "frames": frames, "changes": changes, "packet_size": None}

    def picture_row(self, what, run, task, report, goldens):
        """A row on pictures that a peer has taken, which are to be these goldens, in order."""
        frames, folder = report["frames"], Path(task["folder"])
        picture = goldens[0]
        (first, begin), (last, end) = frames[0], frames[-1]
        return self._row(
            what, PEERS[task["url"].partition(":")[0]][0], frames=len(frames),
            pixels_different=different([np.load(folder / f"{k}.npy") for k in range(len(frames))],
                                       goldens),
            megabytes_per_second=round(picture.nbytes * (last - first) / (end - begin) * 1000, 2),
            underruns=run.broken, resent=report["resent"])

    def command_row(self, what, run, kind):
        """A row on commands of that kind, "gvcp" or "table"."""
        before = len(run.said)
        self.ask(run, {"do": kind, "address": ADDRESS, "count": _COMMANDS})
        clocks = [int(text) for text in re.findall(rf"^ANSWER {kind} (\d+) ", run.said[before:],
                                                   re.MULTILINE)]
        if len(clocks) < _COMMANDS:
            raise SimulationError(f"{_COMMANDS} commands were answered, {len(clocks)} seen")
        return self._row(what, "GVCP" if kind == "gvcp" else "Table I",
                         underruns=run.broken,
                         clocks_per_command=round(statistics.median(clocks)),
                         most_clocks_per_command=max(clocks))


    def corrector_row(self, run):
        """A row on the corrector's last frame: clocks from its start to the last pixel in memory.

        Camera, packetiser and processor use the memory at the same time.
        """
        descriptor = self.model.descriptor
        table = registers(descriptor.hidden_neurons, descriptor.formats, descriptor.nodes)
        at, = (one.address for one in table if one.name == "CLOCKS")
        width, height = descriptor.geometry.corrected
        clocks = self.ask(run, {"do": "register", "address": ADDRESS,
                                "register": CORRECTOR_BASE + 4 * at})
        return self._row("while pictures stream", "corrector",
                         clocks_per_pixel=round(clocks / (width * height), 3))


def _exposures(size):
    return _SMALL_EXPOSURES_US if size[0] < _SMALL else _EXPOSURES_US


def different(pictures, goldens):
    """Pixels that differ, of all pictures together, from golden pictures in their order.

    None of the goldens is left out. They change at the pictures that leave the fewest differences.
    A whole picture counts if there are fewer pictures than goldens.
    """
    costs = np.array([[(picture != golden).any(axis=-1).sum() if picture.shape == golden.shape
                       else golden[..., 0].size for golden in goldens] for picture in pictures])
    best = np.full(len(goldens), np.inf)
    best[0] = costs[0, 0]
    for cost in costs[1:]:
        best = np.minimum(best, np.concatenate([[np.inf], best[:-1]])) + cost
    return int(min(best[-1], goldens[0][..., 0].size * len(pictures)))


def rows_of(size, step):
    """Rows for pictures of that size, (width, height); ``step(text)`` is called for each one.

    Returns
    -------
    list of dict
        ``what``, ``peer``, ``link``, ``mtu``, ``width``, ``height``, ``format``, ``frames``,
        ``pixels_different``, ``resent``; None if not measured. ``megabytes_per_second``: of
        picture, by the time stamps of the frames. ``underruns``: frames that paused or broke on
        the wire, since the start. ``clocks_per_pixel``: of the corrector. ``clocks_per_command``,
        ``most_clocks_per_command``: median and largest number of clocks from the first byte of a
        command's frame to the last one of its answer's.

    Raises
    ------
    SimulationError
        If there can be no such network, or a peer fails.
    """
    step("two lenses")
    lens, other = (trained(Lens(view, size)) for view in (_VIEW, _OTHER_VIEW))
    step("compiling")
    raw = still_photo(lens.geometry)
    exposures = _exposures(size)
    model = SocModel(lens, raw, exposures[0])
    goldens = [model.golden(exposure).picture for exposure in exposures]
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        bench = _Bench(model, Path(name))
        rows = []
        with SocRun(model) as run:
            rows += _idle(bench, run, step)
            rows += _streaming(bench, run, step, goldens)
            rows += _changes(bench, run, step, goldens, other)
        with SocRun(model, loss=LOSS) as run:
            step("packets lost")
            task = bench.pictures("aravis", 8)
            rows.append(bench.picture_row(f"{LOSS / 10:g} % of the packets lost", run, task,
                                          bench.ask(run, task), goldens[:1]))
    step("done")
    return rows


def _idle(bench, run, step):
    for kind in ("gvcp", "table"):
        step(f"{kind}, idle")
        yield bench.command_row("idle", run, kind)


def _streaming(bench, run, step, goldens):
    step("commands while pictures stream")
    task = bench.pictures("aravis", bench.frames_during_commands)
    process = bench.start(run, task)
    run.wait_for(lambda: "streaming" in (bench.folder / "peer.txt").read_text())
    rows = [bench.command_row("while pictures stream", run, kind) for kind in ("gvcp", "table")]
    rows.append(bench.corrector_row(run))
    if process.poll() is not None:
        raise SimulationError("the stream ended before the commands")
    yield from rows
    yield bench.picture_row("commands meanwhile", run, task, bench.report(run, process),
                            goldens[:1])


def _changes(bench, run, step, goldens, other):
    step("another client")
    task = bench.pictures("gige", 3)
    yield bench.picture_row("pictures", run, task, bench.ask(run, task), goldens[:1])
    step("the exposure changes")
    task = bench.pictures("aravis", 3, [("ExposureTime", value) for value in bench.exposures[1:]])
    yield bench.picture_row("exposure changed twice", run, task, bench.ask(run, task), goldens)
    step("the lens changes")
    path = bench.folder / "other.toml"
    other.save(path)
    raw = bench.model.raw_at(bench.exposures[-1])
    after = correct(other, raw).picture
    task = bench.pictures("aravis", 3, [("lens", str(path))])
    yield bench.picture_row("lens changed", run, task, bench.ask(run, task),
                            [goldens[-1], after])
