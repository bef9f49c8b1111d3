"""Bridges between our ports and LiteX's, each with an error: proofs and benches must find it."""

from ncdc_hdl.avalon.native import NativeReader, NativeWriter
from ncdc_hdl.avalon.wishbone import WishboneAgent

__all__ = ["CommandOnly", "Forgets", "TooEarly"]


class TooEarly(NativeReader):
    """Accepts a burst while the last command of the one before is not taken."""

    @staticmethod
    def _accepts(left, ready):
        return left <= 1


class CommandOnly(NativeWriter):
    """Answers as soon as a command has left."""

    @staticmethod
    def _answers(command_left, last_taken):
        return command_left


class Forgets(WishboneAgent):
    """Gives the word of an access that was given up to the next one."""

    @staticmethod
    def _remembered():
        return 0
