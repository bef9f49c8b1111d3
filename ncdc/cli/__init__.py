"""The ``ncdc`` command: one module per subcommand."""

import argparse
import importlib
import os
import sys
import warnings
from importlib.metadata import version

import numpy as np
from amaranth.hdl import UnusedElaboratable

from ncdc_host.client.errors import DeviceError
from ncdc_model.errors import InputError
from ncdc_model.files import check_outputs
from ncdc_model.threads import one_thread
from ncdc_sim.tools import SimulationError

__all__ = ["COMMANDS", "main", "parser"]

# Each module has HELP, EXAMPLE, add_arguments(parser) and run(args); run returns the exit
# status, None for 0.
COMMANDS = ("demo", "calibrate", "train", "evaluate", "correct", "export", "plan", "generate",
            "build", "simulate", "bench", "sensor", "device", "client", "soc")


_TO_FOLDER = ("demo", "generate", "bench", "build")      # commands whose --output is a folder


class _Parser(argparse.ArgumentParser):
    """Prints one sentence on bad usage instead of the whole usage text."""

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}\n")


def parser(command=None):
    """The argument parser of one command, by its name; of all if ``command`` is no such name.

    What the others import takes a second, of which the one that runs has no use.
    """
    top = _Parser(prog="ncdc", description=__doc__ and (
        "From one photo of a calibration target to hardware that straightens the picture."))
    top.add_argument("--version", action="version", version=f"NCDC {version('ncdc')}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name in (command,) if command in COMMANDS else COMMANDS:
        module = importlib.import_module(f"ncdc.cli.{name}")
        sub = commands.add_parser(name, help=module.HELP, description=module.HELP,
                                  epilog=f"example: {module.EXAMPLE}")
        module.add_arguments(sub)
        sub.set_defaults(run=module.run)
    return top


def _files(args):
    """Output and input files among a command's arguments, and outputs that may be streams."""
    given = vars(args)
    streams = [given["json"]] if given.get("json") not in (None, "-") else []
    outputs = []
    if args.command not in _TO_FOLDER and given.get("output"):
        outputs.append(given["output"])
    outputs += [given[name] for name in ("vcd", "fst") if given.get(name)]
    inputs = []
    for name in ("descriptor", "image", "source", "against", "photos"):
        value = given.get(name, [])
        inputs += value if isinstance(value, list) else [value]
    return outputs, inputs, streams


def main(arguments=None):
    """Run a command; the exit status: 0 success, 1 a check failed, 2 bad usage or input."""
    # Of a corrector that is planned for, only the clocks are asked.
    warnings.simplefilter("ignore", UnusedElaboratable)
    arguments = sys.argv[1:] if arguments is None else arguments
    args = parser(arguments[0] if arguments else None).parse_args(arguments)
    try:
        check_outputs(*_files(args))
        # What overflows becomes not-a-number, which the checks of the commands name.
        with np.errstate(all="ignore"), one_thread():
            return args.run(args) or 0
    except InputError as error:
        print(f"ncdc {args.command}: {error}", file=sys.stderr)
        return 2
    except (SimulationError, DeviceError) as error:
        print(f"ncdc {args.command}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print(f"\nncdc {args.command}: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader of our output has left; nothing more can be said to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
