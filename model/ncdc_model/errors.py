"""The one exception that means "your input, not our bug"."""

__all__ = ["InputError"]


class InputError(ValueError):
    """Bad input: the message is one sentence that names the value and the limit.

    The command line prints it on stderr and exits with status 2; anything else that escapes
    a command is a defect of ours and keeps its traceback.
    """
