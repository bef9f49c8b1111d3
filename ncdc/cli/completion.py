"""``ncdc completion``: the script with which a shell completes the command line."""

import argparse
import shlex
from dataclasses import dataclass

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc completion bash > ~/.local/share/bash-completion/completions/ncdc"
_SHELLS = ("bash", "zsh", "fish")


@dataclass(frozen=True)
class _Command:
    """Candidates after some words: the next words, the options with their help and values.

    ``values``: of each option a tuple of words; empty: any, so files are offered; None: it has no
    value.
    """
    words: tuple
    next: dict
    options: dict
    values: dict


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("shell", choices=_SHELLS, metavar="SHELL",
                        help=f"{', '.join(_SHELLS)}; bash: into ~/.local/share/bash-completion/"
                             f"completions/ncdc; zsh: into a file that .zshrc reads by source; "
                             f"fish: into ~/.config/fish/completions/ncdc.fish")


def run(args) -> None:
    """Print the script."""
    from ncdc.cli import parser
    commands = [*_commands(parser(), ())]
    print({"bash": _bash, "zsh": _zsh, "fish": _fish}[args.shell](commands), end="")


def _commands(parser, words):
    """:class:`_Command` of a parser and of all below it."""
    following, options, values = {}, {}, {}
    below = []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {choice.dest: choice.help or "" for choice in action._choices_actions}
            following = {name: helps.get(name, "") for name in action.choices}
            below = list(action.choices.items())
        elif action.help != argparse.SUPPRESS:
            for name in action.option_strings:
                options[name] = action.help or ""
                values[name] = None if action.nargs == 0 else tuple(map(str, action.choices or ()))
            if not action.option_strings:
                following |= {str(choice): "" for choice in action.choices or ()}
    yield _Command(words, following, options, values)
    for name, one in below:
        yield from _commands(one, (*words, name))


def _bash(commands):
    """Script of one function: it finds the command among the words, then completes the next one."""
    walk = [f"            {shlex.quote(' '.join((*one.words, name)).strip())}) ;;"
            for one in commands for name in one.next
            if any(other.words == (*one.words, name) for other in commands)]
    cases = []
    for one in commands:
        rest = f"words={shlex.quote(' '.join((*one.next, *one.options)))} ;;"
        values = [f"                {name}) words={shlex.quote(' '.join(words))} ;;"
                  for name, words in one.values.items() if words is not None]
        cases += [f"        {shlex.quote(' '.join(one.words))})",
                  '            case "$previous" in', *values,
                  f"                *) {rest}", "            esac ;;"]
    return "\n".join([
        "# Completion of ncdc, made by ncdc completion.", "_ncdc() {",
        "    local current previous path word words i", '    current="${COMP_WORDS[COMP_CWORD]}"',
        '    previous="${COMP_WORDS[COMP_CWORD-1]}"', '    path="" words=""',
        "    for ((i = 1; i < COMP_CWORD; i++)); do",
        '        word="${path:+$path }${COMP_WORDS[i]}"',
        '        case "$word" in', *walk, "            *) continue ;;", "        esac",
        '        path="$word"', "    done", '    case "$path" in', *cases, "    esac",
        '    COMPREPLY=($(compgen -W "$words" -- "$current"))', "}",
        "complete -o default -o bashdefault -F _ncdc ncdc", ""])


def _zsh(commands):
    """zsh runs bash's function by a compatible layer of its own."""
    return ("autoload -U +X compinit && compinit\nautoload -U +X bashcompinit && bashcompinit\n"
            + _bash(commands).replace(" -o bashdefault", ""))


def _fish(commands):
    lines = ["# Completion of ncdc, made by ncdc completion."]
    for one in commands:
        seen = "; and ".join(f"__fish_seen_subcommand_from {word}" for word in one.words)
        inner = [name for name in one.next
                 if any(other.words == (*one.words, name) for other in commands)]
        if inner:
            none = f"not __fish_seen_subcommand_from {' '.join(inner)}"
            seen = f"{seen}; and {none}" if seen else none
        start = "complete -c ncdc" + (f" -n {_quoted(seen)}" if seen else "")
        lines += [f"{start} -f -a {_quoted(name)} -d {_quoted(text)}"
                  for name, text in one.next.items()]
        for name, text in one.options.items():
            kind = f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}"
            words = one.values[name]
            value = ""
            if words is not None:
                value = f" -x -a {_quoted(' '.join(words))}" if words else " -r"
            lines.append(f"{start} {kind}{value} -d {_quoted(text)}")
    return "\n".join(lines) + "\n"


def _quoted(text):
    """In single quotes, in which fish knows two escapes."""
    text = " ".join(text.replace("%%", "%").split())
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
