"""Interfaces as ports of a top module, called prefix_member."""

from amaranth.lib.wiring import Out

__all__ = ["flat", "join", "members_of", "ports_as"]


def flat(prefix, signature, flow):
    """Members of ``signature`` as ports called prefix_member."""
    return {f"{prefix}_{name}": flow(member.shape) if member.flow is Out else
            flow(member.shape).flip() for name, member in signature.members.items()}


def join(m, component, prefix, interface):
    """Connect the ports prefix_member of ``component`` with the members of ``interface``.

    Used inside the component: its outputs are driven by the interface, which has
    the same directions.
    """
    for name in interface.signature.members:
        port, inner = getattr(component, f"{prefix}_{name}"), getattr(interface, name)
        out = component.signature.members[f"{prefix}_{name}"].flow is Out
        m.d.comb += port.eq(inner) if out else inner.eq(port)


def ports_as(component, prefix, signature):
    """The ports prefix_member of ``component`` as an interface of ``signature``, from outside."""
    interface = signature.create()
    for name in signature.members:
        setattr(interface, name, getattr(component, f"{prefix}_{name}"))
    return interface


def members_of(component, signature):
    """The members of ``component`` that ``signature`` has, as an interface, from outside."""
    interface = signature.create()
    for name in signature.members:
        setattr(interface, name, getattr(component, name))
    return interface
