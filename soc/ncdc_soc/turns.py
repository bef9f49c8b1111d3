"""LiteDRAM's controller with fewer changes between reads and writes of a corrector."""

from litedram.core.controller import ControllerSettings

__all__ = ["long_turns"]


def long_turns():
    """LiteDRAM's ControllerSettings for a memory that a corrector shares.

    While a write waits, reads have at most 128 clocks, writes 64 while a read waits (LiteDRAM's
    own: 32 and 16). Each bank has a queue of 16 commands (8). Each change costs clocks in which no
    word moves.
    """
    return ControllerSettings(cmd_buffer_depth=16, read_time=128, write_time=64)
