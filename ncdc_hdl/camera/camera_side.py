"""What lies in the sensor's clock: a source of samples, and the port that captures them."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out, connect

from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_hdl.camera.sensor_port import SensorPort
from ncdc_hdl.lib.ports import forward

__all__ = ["CameraSide"]

_SIZES = {"width": "sent_width", "height": "sent_height"}       # inputs of sources, by setting


class CameraSide(wiring.Component):
    """A source, and the :class:`SensorPort` that takes its samples.

    Parameters
    ----------
    source : wiring.Component, optional
        Its output ``o`` is of :func:`ncdc_hdl.camera.samples.samples`. Inputs ``width`` and
        ``height``, if it has them, are those that the settings say that the sensor sends. An output
        ``faults`` has bits that are high for a clock. By default a :class:`ParallelSource`.
    grid : int, optional
        As in :class:`SensorPort`.

    Members
    -------
    camera : ``Out``
        The source's other members: ``camera.pins`` of a parallel sensor.
    faults : ``Out``
        Those of the source, if it has any.
    enable, settings, grid, balance, active, entry, push, space
        As in :class:`SensorPort`.
    """

    def __init__(self, source=None, grid=None):
        self.source = ParallelSource() if source is None else source
        self.port = SensorPort(len(self.source.o.valid), grid)
        self.outside = wiring.Signature({
            name: member for name, member in self.source.signature.members.items()
            if name not in ("o", "faults", *_SIZES)})
        self.passed = wiring.Signature({
            name: member for name, member in self.port.signature.members.items() if name != "i"})
        members = self.source.signature.members
        self.faults_layout = members["faults"].shape if "faults" in members else None
        super().__init__({
            "camera": Out(self.outside), **self.passed.members,
            **({"faults": Out(self.faults_layout)} if self.faults_layout else {})})

    def elaborate(self, platform):
        m = Module()
        m.submodules.source = source = self.source
        m.submodules.port = port = self.port
        connect(m, source.o, port.i)
        forward(m, self.outside, self.camera, source)
        forward(m, self.passed, self, port)
        for name, setting in _SIZES.items():
            if name in source.signature.members:
                m.d.comb += getattr(source, name).eq(self.settings[setting])
        if self.faults_layout:
            m.d.comb += self.faults.eq(source.faults)
        return m
