"""The ``ncdc`` command: one module per subcommand, imported when it runs."""

import argparse
import importlib
import importlib.util
import os
import re
import sys
from importlib.metadata import version

from ncdc.cli.commands import COMMANDS, EXTRAS, LATE
from ncdc.terminal import say
from ncdc_spec.errors import InputError

__all__ = ["COMMANDS", "main", "parser"]

# Commands whose --output is a folder, or that check it themselves.
_TO_FOLDER = ("demo", "generate", "bench", "build", "lot", "client")
_LIGHT = ("doctor",)                # commands that work where the packages of the others do not
_INTERRUPTED = 130                  # exit status of programs that Ctrl-C has ended


class _Parser(argparse.ArgumentParser):
    """Prints one sentence on bad usage instead of the whole usage text."""

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        # Before Python 3.14, -1e-5 is taken for an option.
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message):
        self.exit(2, f"{self.prog}: {message}\n")


def parser(command=None):
    """The argument parser of one command, by its name; of all if ``command`` is no such name.

    The imports of the other commands take a second, and the command that runs needs none of them.
    """
    top, commands = _top()
    for name in (command,) if command in COMMANDS else COMMANDS:
        try:
            module = importlib.import_module(f"ncdc.cli.{name}")
            late = LATE.get(name)
            if late and importlib.util.find_spec(late) is None:
                raise ModuleNotFoundError(f"No module named {late!r}", name=late)
        except ModuleNotFoundError:
            if name == command or name not in EXTRAS:
                raise
            commands.add_parser(name, help=COMMANDS[name])  # its extra is not installed
            continue
        sub = commands.add_parser(name, help=COMMANDS[name], description=COMMANDS[name],
                                  epilog=f"example: {module.EXAMPLE}")
        module.add_arguments(sub)
        sub.set_defaults(run=module.run)
    return top


def _overview():
    """The parser without any command's arguments: it needs none of their modules."""
    top, commands = _top()
    for name, text in COMMANDS.items():
        commands.add_parser(name, help=text)
    return top


def _top():
    """Parser of the options that belong to no command, and the group of the commands' parsers."""
    top = _Parser(prog="ncdc", description=(
        "From one photo of a calibration target to hardware that straightens the picture."))
    top.add_argument("--version", action="version", version=f"NCDC {version('ncdc')}")
    return top, top.add_subparsers(dest="command", metavar="COMMAND", required=True)


def _to_folder(args):
    """Whether --output is a folder: of some commands always, of others for several pictures."""
    images = getattr(args, "image", None)
    return args.command in _TO_FOLDER or (
        isinstance(images, list) and (len(images) > 1 or not os.path.isfile(images[0])))


def _files(args):
    """Output and input files among a command's arguments, and outputs that may be streams."""
    given = vars(args)
    streams = [given[name] for name in ("json", "states") if given.get(name) not in (None, "-")]
    outputs = []
    if not _to_folder(args) and given.get("output"):
        outputs.append(given["output"])
    outputs += [given[name] for name in ("vcd", "fst") if given.get(name)]
    inputs = []
    for name in ("descriptor", "image", "source", "reference", "previous", "calibration", "photo",
                 "photos", "view_list", "gyro", "eeprom"):
        value = given.get(name) or []
        inputs += value if isinstance(value, list) else [value]
    return outputs, inputs, streams


def main(arguments=None):
    """Run a command; the exit status: 0 success, 1 a check failed, 2 bad usage or input, 130
    interrupted."""
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    name = arguments[0] if arguments and arguments[0] in COMMANDS else None
    try:
        if name is None:
            name = _overview().parse_args(arguments).command
        return _run(name, parser(name).parse_args(arguments))
    except InputError as error:
        say(f"ncdc {name}: {error}")
        return 2
    except ModuleNotFoundError as error:
        from ncdc.capabilities import package_of
        lost = package_of(error.name or "", EXTRAS.get(name, ""))
        if lost is None:
            raise                   # an error of ours
        say(f"ncdc {name}: {lost.what} is not installed: {lost.line}")
        return 2
    except KeyboardInterrupt:
        say(f"ncdc {name or ''}".rstrip() + ": interrupted")
        return _INTERRUPTED
    except BrokenPipeError:
        # The reader of stdout has closed the pipe: nothing more can be written to it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _run(name, args):
    """Exit status of the command ``name``."""
    if name in _LIGHT:
        return args.run(args) or 0

    import numpy as np

    from ncdc.cli.roles import check_roles
    from ncdc_model.threads import one_thread
    from ncdc_spec.files import check_outputs
    _ignore_unused()
    try:
        check_outputs(*_files(args))
        check_roles(args)
        # What overflows becomes not-a-number, which the checks of the commands name.
        with np.errstate(all="ignore"), one_thread():
            return args.run(args) or 0
    except InputError:
        raise                   # some errors of devices are both, and are bad input then
    except Exception as error:
        if not isinstance(error, _failures()):
            raise
        say(f"ncdc {name}: {error}")
        return 1


def _failures():
    """Classes of errors that are no bad input: of devices, and of simulators if one was loaded."""
    from ncdc_host.client.errors import DeviceError
    simulators = sys.modules.get("ncdc_sim.tools")
    return (DeviceError, simulators.SimulationError) if simulators else DeviceError


def _ignore_unused():
    """Silence Amaranth's warning about components that are never elaborated.

    The planner creates a corrector only to ask for its clocks.
    """
    import warnings
    # By its text: the class would import Amaranth, which many commands do without.
    warnings.filterwarnings("ignore", "(?s).* created but never used")
