"""Commands of ``ncdc`` called as from a shell, but with exceptions for errors."""

import argparse

__all__ = ["call"]


def call(command, *arguments):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    command.run(parser.parse_args([str(argument) for argument in arguments]))
