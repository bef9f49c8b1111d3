"""The process that runs Aravis has a time limit."""

import pytest

from devices import device
from ncdc_host.client import DeviceGone, aravis, open_device
from ncdc_spec.protocols import gvcp
from ncdc_spec.protocols.genicam import genicam_xml
from peers import need


@pytest.mark.longer
def test_xml_at_which_aravis_never_ends_has_a_time_limit(monkeypatch):
    need("aravis")
    monkeypatch.setattr(aravis, "_SECONDS_ELSE", 1.0)
    cyclic = genicam_xml().replace(b"<pValue>WidthRegister", b"<pValue>Width")
    with device() as one:
        one.agent._xml = cyclic + bytes(-len(cyclic) % 4)
        url = gvcp.register("FirstUrl")
        one.agent._texts[url.address] = (
            f"Local:x.xml;{gvcp.XML_BASE:X};{len(cyclic):X}".encode().ljust(url.length, b"\0"))
        with open_device(f"aravis://{one.options.address}", monitor=True) as opened:
            with pytest.raises(DeviceGone, match="has not answered for 1 seconds"):
                opened.info("Width")
            with pytest.raises(DeviceGone, match="has ended"):
                opened.info("Gain")
