"""Shell completion, asked of the shells themselves."""

import shutil
import subprocess

import pytest

from ncdc.cli import COMMANDS, main


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """Files of the scripts, by shell."""
    folder = tmp_path_factory.mktemp("completion")
    made = {}
    with pytest.MonkeyPatch.context() as patch:
        for shell in ("bash", "zsh", "fish"):
            said = []
            patch.setattr("builtins.print", lambda text, end="\n": said.append(text))
            assert main(["completion", shell]) == 0
            made[shell] = folder / shell
            made[shell].write_text("".join(said))
    return made


def asked(shell, scripts, line):
    """What ``shell`` offers for the last word of ``line``."""
    # NCDC does not need the other shells, so its installation does not install them.
    if shell != "bash" and shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    words = line.split(" ")
    if shell == "fish":
        code = f"source {scripts['fish']}; complete -C '{line}'"
    else:
        start = "autoload -U +X compinit && compinit -u; setopt kshglob braceexpand ksharrays " \
            "shwordsplit; compdef() {{ :; }}; " if shell == "zsh" else ""
        code = (f"{start}source {scripts[shell]}; COMP_WORDS=({' '.join(map(repr, words))}); "
                f"COMP_CWORD={len(words) - 1}; _ncdc; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
    options = {"bash": ["--norc"], "zsh": ["-f"], "fish": ["--no-config"]}[shell]
    done = subprocess.run([shell, *options, "-c", code], capture_output=True, text=True)
    assert not done.stderr, done.stderr
    offered = {word.partition("\t")[0] for word in done.stdout.split("\n") if word}
    # zsh's compgen leaves what does not fit the word to zsh itself.
    return {word for word in offered if shell != "zsh" or word.startswith(words[-1])}


SHELLS = pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])


@SHELLS
def test_commands(shell, scripts):
    assert asked(shell, scripts, "ncdc ") >= set(COMMANDS)
    assert asked(shell, scripts, "ncdc ca") == {"calibrate"}


@SHELLS
def test_options_of_a_command(shell, scripts):
    assert asked(shell, scripts, "ncdc train points.json --tr") == {"--trainer"}
    assert asked(shell, scripts, "ncdc plan net.toml --min") == {"--min-fps"}


@SHELLS
def test_values_of_an_option(shell, scripts):
    assert asked(shell, scripts, "ncdc train points.json --trainer ") == {"lm", "ebp"}
    assert asked(shell, scripts, "ncdc train points.json --bayer MO") == {"MONO"}


@SHELLS
def test_actions_of_a_command(shell, scripts):
    assert asked(shell, scripts, "ncdc client ") >= {"list", "show", "grab", "set", "gui"}
    assert asked(shell, scripts, "ncdc soc run --packet") == {"--packet-loss"}


@SHELLS
def test_an_old_name_is_not_offered(shell, scripts):
    assert "--rate" not in asked(shell, scripts, "ncdc plan net.toml --r")


@pytest.mark.parametrize("shell", ["bash"])
def test_files_are_left_to_the_shell(shell, scripts):
    """Where nothing of ours fits, `complete -o default` offers files."""
    assert asked(shell, scripts, "ncdc correct ne") == set()
    assert asked(shell, scripts, "ncdc train x --size ") == set()
    assert "complete -o default" in scripts["bash"].read_text()


def test_another_shell(capsys):
    with pytest.raises(SystemExit):
        main(["completion", "tcsh"])
    assert "'tcsh' (choose from 'bash', 'zsh', 'fish')" in capsys.readouterr().err
