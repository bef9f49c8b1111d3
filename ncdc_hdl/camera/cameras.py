"""The sources of a system's camera, and their ports."""

from ncdc_hdl.camera.avalon_st_source import AvalonStSource
from ncdc_hdl.camera.axis_source import AxisSource
from ncdc_hdl.camera.csi2.receiver import Receiver
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_hdl.camera.serializer import SerialReceiver
from ncdc_spec.camera_port import AVALON_ST, AXIS, CSI2, VIP

__all__ = ["camera_ports", "source_of"]


def source_of(camera):
    """The source of a :class:`ncdc_spec.camera_port.CameraPort`."""
    if camera.kind == AXIS:
        return AxisSource(camera.samples, camera.bits)
    if camera.kind in (AVALON_ST, VIP):
        return AvalonStSource(camera.samples, camera.bits, control=camera.kind == VIP)
    if camera.kind == CSI2:
        receiver = SerialReceiver if camera.serial else Receiver
        return receiver(camera.samples, aligned=camera.aligned)
    return ParallelSource()


def camera_ports(interface):
    """Ports of a system: {name: (member, signal)} of the members of :class:`Capture`'s ``camera``.

    ``interface``: that member; its settings come from registers.
    """
    ports = {}
    for path, member, signal in interface.signature.flatten(interface):
        if path[0] == "i":
            path = f"lane{path[1]}", path[2]
        elif path[0] == "pins":
            path = path[1:]
        if path[0] != "settings":
            ports[f"sensor_{'_'.join(path)}"] = member, signal
    return ports
