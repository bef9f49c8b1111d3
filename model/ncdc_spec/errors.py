"""The one exception that means "your input, not our bug"."""

from contextlib import contextmanager

__all__ = ["InputError", "reading"]


class InputError(ValueError):
    """Bad input: the message is one sentence that names the value and the limit.

    The command line prints it on stderr and exits with status 2; anything else that escapes
    a command is a defect of ours and keeps its traceback.
    """


@contextmanager
def reading(subject):
    """Name ``subject``, a file, when one of its values turns out missing, wrong or of a wrong kind.

    Raises
    ------
    InputError
        In place of the KeyError, InputError, TypeError, ValueError or OverflowError of the block.
    """
    try:
        yield
    except KeyError as error:
        raise InputError(f"{subject} lacks the value {error}") from error
    except InputError as error:
        raise InputError(f"{subject}: {error}") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{subject} holds a value of the wrong kind: {error}") from error
