"""Pins as litex-boards has them, to compare ours with."""

__all__ = ["litex_pins"]


def litex_pins(resources, resource, number, signal):
    """Pins of a signal in a list of litex-boards' resources; ``signal`` None: the resource's own.

    Raises
    ------
    KeyError
        If the list has no such resource.
    """
    for name, index, *parts in resources:
        if (name, index) == (resource, number):
            if signal is not None:
                parts = next(part for part in parts
                             if getattr(part, "name", None) == signal).constraints
            return list(next(part for part in parts if hasattr(part, "identifiers")).identifiers)
    raise KeyError((resource, number, signal))
