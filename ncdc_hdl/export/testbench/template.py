"""A module's instantiation, to be copied into a design."""

from ncdc_hdl.export.testbench.ports import ports_of_text

__all__ = ["instantiation"]


def instantiation(verilog, module):
    """Text of ``<module>_template.v``: a wire for each port of ``module`` of ``verilog`` and an
    instance that connects them, with the port list's own comments."""
    ports = ports_of_text(verilog, module)
    width = max(len(port.name) for port in ports)
    lines = [f"// Instantiation of {module}: to be copied. Each port has a wire of its name."]
    for port in ports:
        lines += [f"// {port.title}"] if port.title else []
        lines.append(f"wire {port.range:>7} {port.name};".ljust(width + 16) + f"// {port.about}")
    lines += ["", f"{module} {module}_i ("]
    for k, port in enumerate(ports):
        lines += [f"    // {port.title}"] if port.title else []
        end = "," if k < len(ports) - 1 else ""
        lines.append(f"    .{port.name.ljust(width)} ({port.name.ljust(width)}){end}")
    return "\n".join([*lines, ");", ""])
