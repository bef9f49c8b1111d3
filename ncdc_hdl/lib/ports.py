"""Interfaces as ports of a top module, called prefix_member."""

from amaranth.lib.wiring import Out

__all__ = ["flat", "forward", "join", "ports_as"]


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


def forward(m, signature, outer, inner):
    """Connect the members of ``signature`` of ``outer`` with those of ``inner``, a part of it."""
    for (_, member, ours), (_, _, theirs) in zip(signature.flatten(outer),
                                                 signature.flatten(inner)):
        m.d.comb += ours.eq(theirs) if member.flow is Out else theirs.eq(ours)
