"""Lines of scripts for ``qsys-script``."""

__all__ = ["connect", "header", "instance", "exported"]


def header(system, family, device, search=""):
    """First lines of a script that makes ``system``.qsys."""
    return [f"# Makes {system}.qsys: qsys-script --script={system}.tcl{search}",
            "package require -exact qsys 16.1", "", f"create_system {system}",
            f"set_project_property DEVICE_FAMILY {{{family}}}",
            f"set_project_property DEVICE {device}", ""]


def instance(name, kind, parameters):
    """A component with its parameters."""
    return [f"add_instance {name} {kind}",
            *(f"set_instance_parameter_value {name} {key} {value}"
              for key, value in parameters.items()), ""]


def connect(host, agent, base):
    """A memory-mapped connection."""
    return [f"add_connection {host} {agent}",
            f"set_connection_parameter_value {host}/{agent} baseAddress 0x{base:08x}"]


def exported(name, kind, inner):
    """An interface of the system."""
    return [f"add_interface {name} {kind}", f"set_interface_property {name} EXPORT_OF {inner}"]
