"""The exception for bad input, as distinct from defects of NCDC."""

from contextlib import contextmanager

__all__ = ["InputError", "reading"]


class InputError(ValueError):
    """Bad input: the message is one sentence that names the value and the limit.

    The command line prints it on stderr and exits with status 2. Any other exception of
    a command is a defect and has a traceback.
    """


@contextmanager
def reading(subject):
    """Name ``subject``, a file, in the error if a value is missing, bad or of a wrong kind.

    Raises
    ------
    InputError
        For a KeyError, InputError, TypeError, ValueError or OverflowError of the block.
    """
    try:
        yield
    except KeyError as error:
        raise InputError(f"{subject} lacks the value {error}") from error
    except InputError as error:
        raise InputError(f"{subject}: {error}") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{subject} holds a value of the wrong kind: {error}") from error
