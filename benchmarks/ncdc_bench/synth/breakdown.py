"""Which module of a block each cell of its flat netlist belongs to."""

import re
from bisect import bisect
from collections import Counter, defaultdict

from ncdc.toolchain.flows import paired

__all__ = ["RESOURCES", "breakdown", "totals"]

RESOURCES = ("alm", "le", "lut", "ff", "dsp", "ram_blocks")

_LINE = re.compile(r"design\.v:(\d+)\.")
_FF = ("MISTRAL_FF", "dffeas")
_LUT = ("MISTRAL_ALUT", "cycloneive_lcell_comb", "MISTRAL_MLAB")
_RAM = ("MISTRAL_M10K", "NCDC_M9K")
# Products that a DSP block has space for: of 27 x 27 bits on Cyclone V one, and so on.
_DSP = {"MISTRAL_MUL27X27": 1, "MISTRAL_MUL18X18": 1 / 2, "MISTRAL_MUL9X9": 1 / 3,
        "NCDC_MUL18X18": 1}


def breakdown(tree, flat, top):
    """Cells of a netlist by the instance that each belongs to.

    A cell that has a line of the Verilog belongs to the module of that line. Memories have the
    names of their instances. A LUT belongs to the instance that declares the signal it gives.
    A LUT inside an expression belongs to the instance of most of the cells that read it.

    Parameters
    ----------
    tree : dict
        Yosys's JSON of the Verilog as it is read, a module each.
    flat : dict
        Yosys's JSON of the flat netlist for a Cyclone.
    top : str

    Returns
    -------
    list of dict
        ``path``: names of the instances from the top on, "" for the top's own cells; ``module``.
        ``lut``, ``ff``, ``dsp``, ``ram_blocks``: of the instance without those in it. ``le``:
        logic elements of Cyclone IV, else None. ``alm``: on Cyclone V half of ``lut``, else None.
        A fraction of a DSP block or ALM is what the cells fill of one. All rows of ``le``,
        ``lut``, ``ff`` and ``ram_blocks`` add up to the figures of the netlist.
    """
    return _Netlist(tree["modules"], flat["modules"][top], top).rows()


def totals(rows):
    """Rows of :func:`breakdown`, each with its figures and those of all instances in it."""
    def inside(path):
        return [row for row in rows if not path or row["path"] == path
                or row["path"].startswith(f"{path}.")]
    return [row | {name: None if row[name] is None else
                   round(sum(one[name] for one in inside(row["path"])), 3) for name in RESOURCES}
            for row in rows]


class _Netlist:
    """A flat netlist with the instances that it was made of."""

    def __init__(self, modules, flat, top):
        self.cells = flat["cells"]
        self.instances = dict(_instances(modules, top))         # path: module
        self.of_module = defaultdict(list)
        for path, module in self.instances.items():
            self.of_module[module].append(path)
        starts = sorted((int(_LINE.match(module["attributes"]["src"])[1]), name)
                        for name, module in modules.items() if "src" in module["attributes"])
        self.lines, self.at_line = zip(*starts)
        self.wires = _Wires(modules, self.instances)
        self.named = self._named(modules, flat["netnames"])
        self.readers = defaultdict(list)
        for name, cell in self.cells.items():
            for bit in _bits(cell, "input"):
                self.readers[bit].append(name)
        self.owners = {}                                        # path by the cell's name

    def rows(self):
        """The result of :func:`breakdown`."""
        for name, cell in self.cells.items():
            if not _is_lut(cell) or _LINE.search(cell["attributes"].get("src", "")):
                self.owners[name] = self._by_source(name, cell)
        for name in self.cells:
            self._assign(name)
        followed = paired(self.cells)
        cyclone_iv = any(cell["type"] in ("dffeas", "cycloneive_lcell_comb")
                         for cell in self.cells.values())
        sums = {path: Counter() for path in self.instances}
        for name, cell in self.cells.items():
            sums[self.owners[name]].update(_amounts(name, cell, followed))
        return [{"path": path, "module": self.instances[path],
                 "alm": None if cyclone_iv else one["lut"] / 2,
                 "le": one["le"] if cyclone_iv else None, "lut": one["lut"], "ff": one["ff"],
                 "dsp": round(one["dsp"], 3), "ram_blocks": one["ram_blocks"]}
                for path, one in sums.items()]

    def _named(self, modules, nets):
        """Path of the instance that drives a bit, by bit, for those with a name of the Verilog."""
        named = {}
        for name, net in nets.items():
            path, _, local = name.rpartition(".")
            known = modules.get(self.instances.get(path), {"netnames": {}})["netnames"]
            bits = known.get(local, {"bits": []})["bits"]
            if len(bits) == len(net["bits"]):
                named |= {bit: self.wires.driver(path, own) for bit, own in zip(net["bits"], bits)
                          if bit not in named}
        return named

    def _by_source(self, name, cell):
        """Path of a cell that has a line of the Verilog, or the name of its instance."""
        of_name = self._prefix(name)
        line = _LINE.search(cell["attributes"].get("src", ""))
        if not line:
            return of_name
        module = self.at_line[bisect(self.lines, int(line[1])) - 1]
        paths = self.of_module[module]
        if len(paths) == 1:
            return paths[0]
        outputs = [self.named[bit] for bit in _bits(cell, "output") if bit in self.named]
        return max(paths, key=lambda path: (outputs.count(path), of_name == path,
                                            of_name.startswith(path)))

    def _prefix(self, name):
        """The longest path of an instance that ``name`` begins with."""
        while name and name not in self.instances:
            name = name.rpartition(".")[0]
        return name

    def _assign(self, name):
        """Find the instance of LUT ``name``, and of the LUTs after it, without recursion."""
        stack = [name]
        while stack:
            cell = self.cells[stack[-1]]
            if stack[-1] in self.owners:
                stack.pop()
                continue
            outputs = _bits(cell, "output")
            own = [self.named[bit] for bit in outputs if bit in self.named]
            readers = [] if own else [r for bit in outputs for r in self.readers[bit]]
            unknown = [r for r in readers if r not in self.owners]
            if unknown and not set(unknown) & set(stack):
                stack += unknown
                continue
            found = own or [self.owners[r] for r in readers if r in self.owners]
            self.owners[stack.pop()] = (Counter(found).most_common(1)[0][0] if found
                                        else self._prefix(name))


class _Wires:
    """Finds the instance that drives a bit of a module."""

    def __init__(self, modules, instances):
        self.modules, self.instances = modules, instances
        self.inputs = {name: {bit: (port, k) for port, one in module["ports"].items()
                              if one["direction"] == "input" for k, bit in enumerate(one["bits"])}
                       for name, module in modules.items()}
        self.outputs = {name: dict(self._of_instances(module)) for name, module in modules.items()}

    def driver(self, path, bit):
        """Path of the instance that drives ``bit`` of the one at ``path``, through ports."""
        while isinstance(bit, int):
            module = self.instances[path]
            if bit in self.outputs[module]:
                name, inner, port, k = self.outputs[module][bit]
                path = f"{path}.{name}" if path else name
                bit = self.modules[inner]["ports"][port]["bits"][k]
            elif path and bit in self.inputs[module]:
                port, k = self.inputs[module][bit]
                path, _, name = path.rpartition(".")
                outer = self.modules[self.instances[path]]
                bit = outer["cells"][name]["connections"][port][k]
            else:
                break
        return path

    def _of_instances(self, module):
        """Each bit that an instance in ``module`` drives: its name, its module, port and index."""
        for name, cell in module["cells"].items():
            ports = self.modules.get(cell["type"], {"ports": {}})["ports"]
            for port, one in ports.items():
                if one["direction"] == "output":
                    for k, bit in enumerate(cell["connections"].get(port, [])):
                        yield bit, (name, cell["type"], port, k)


def _instances(modules, module, path=""):
    """(path, module) of ``module`` and of all instances in it."""
    yield path, module
    for name, cell in modules[module]["cells"].items():
        if cell["type"] in modules:
            yield from _instances(modules, cell["type"], f"{path}.{name}" if path else name)


def _bits(cell, direction):
    """Bits of a cell's ports of a direction, constants excluded."""
    return [bit for port, bits in cell["connections"].items()
            if cell["port_directions"].get(port) == direction
            for bit in bits if isinstance(bit, int)]


def _is_lut(cell):
    return cell["type"].startswith(_LUT[:2])


def _amounts(name, cell, followed):
    """What one cell adds to the sums of its instance; ``followed``: names of flip-flops that share
    the logic element of a LUT."""
    kind = cell["type"]
    lut, ff = kind.startswith(_LUT), kind in _FF
    return {"lut": int(lut), "ff": int(ff), "le": int(lut or (ff and name not in followed)),
            "ram_blocks": int(kind in _RAM), "dsp": _DSP.get(kind, 0)}
