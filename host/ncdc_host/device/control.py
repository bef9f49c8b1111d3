"""The GVCP agent: who may control the device, and its memory as the network sees it."""

import struct
import threading
import time
from dataclasses import replace
from ipaddress import IPv4Address

from ncdc_host.device.registers import Rejected
from ncdc_host.device.stream import Receiver
from ncdc_spec.eeprom import NO_CHIP
from ncdc_spec.protocols import gvcp, gvsp
from ncdc_spec.protocols.features import feature
from ncdc_spec.protocols.genicam import genicam_xml

__all__ = ["ControlAgent", "Identity"]

_STATUS = {"value": gvcp.INVALID_PARAMETER, "locked": gvcp.ACCESS_DENIED,
           "read only": gvcp.WRITE_PROTECT}
_RESENT_PER_SECOND = 200_000    # packets: no request may keep the agent busy for long
_SOURCE_PORT = gvcp.register("StreamSourcePort").address


class _Status(Exception):
    """Ends a command with a status other than success."""
    def __init__(self, status):
        super().__init__(hex(status))
        self.status = status


class Identity:
    """Identity of a device: its names and addresses.

    Parameters
    ----------
    address : str
        Its IPv4 address.
    serial : str
        Up to 15 characters.
    mask : str
        Mask of its net.
    eeprom : int
        What the feature EepromStatus shows.
    """
    def __init__(self, address, serial, version, mask="255.255.255.0", eeprom=NO_CHIP):
        number = int(IPv4Address(address))
        self.address = address
        # Locally administered; the address makes it unique on its net.
        self.mac = 0x02_4E_00_00_00_00 | number
        self.numbers = {
            "Version": 0x0001_0002, "DeviceMode": 0x8000_0001, "MacHigh": self.mac >> 32,
            "MacLow": self.mac & 0xFFFFFFFF, "IpOptions": 0x6, "IpConfiguration": 0x4,
            "IpAddress": number, "SubnetMask": int(IPv4Address(mask)), "Gateway": 0,
            "NetworkInterfaces": 1, "MessageChannels": 0, "StreamChannels": 1,
            "Capability": gvcp.CAPABILITY, "TickFrequencyHigh": 0,
            "TickFrequencyLow": 1_000_000_000, "PendingTimeout": gvcp.PENDING_MS,
            "EepromStatus": eeprom}
        self.texts = {
            "DeviceVendorName": "NCDC", "DeviceModelName": "NCDC emulated device",
            "DeviceVersion": version, "DeviceManufacturerInfo": "distortion correction",
            "DeviceSerialNumber": serial, "DeviceUserID": "", "SecondUrl": ""}


class ControlAgent:
    """Answers GVCP datagrams; no socket of its own, so that a test can feed it anything.

    Parameters
    ----------
    identity : Identity
    registers : Registers
    camera : Camera
    stream : Stream
    corrector : CorrectorWindow
        The corrector's registers, at ``gvcp.CORRECTOR_BASE``.
    """
    def __init__(self, identity, registers, camera, stream, corrector):
        self._identity, self._registers = identity, registers
        self._camera, self._stream, self._corrector = camera, stream, corrector
        self._xml = genicam_xml(features=registers.features)
        self._words = {}                # numbers of the bootstrap registers by address
        self._texts = {}                # (address, bytes) of texts
        for name, value in identity.numbers.items():
            self._words[gvcp.register(name).address] = value
        url = f"Local:{gvcp.XML_NAME};{gvcp.XML_BASE:X};{len(self._xml):X}"
        self._xml += bytes(-len(self._xml) % 4)
        for name, text in {**identity.texts, "FirstUrl": url}.items():
            register = gvcp.register(name)
            self._texts[register.address] = text.encode().ljust(register.length, b"\0")
        self._features = {one.address: one for one in registers.features
                          if one.address >= gvcp.FEATURE_BASE}
        self._writable = {register.address: register.name for register in gvcp.BOOTSTRAP
                          if register.access == "rw"}
        self._sensor_address = self._ratio = 0
        self._commands = {
            gvcp.DISCOVERY: self._discovery, gvcp.FORCEIP: self._forceip,
            gvcp.READREG: self._readreg, gvcp.WRITEREG: self._writereg,
            gvcp.READMEM: self._readmem, gvcp.WRITEMEM: self._writemem,
            gvcp.PACKETRESEND: self._packetresend}
        self._resend_budget = (0.0, float(_RESENT_PER_SECOND))
        self._lock = threading.RLock()
        self.controller = None          # (address, port) that holds control
        self._heard = 0.0
        self._release()

    # Datagrams.

    def handle(self, data, peer, now=None):
        """The answer to a datagram of ``peer``, (address, port); None if there is none."""
        return next(iter(self.answers(data, peer, now)[-1:]), None)

    def answers(self, data, peer, now=None):
        """All answers to a datagram of ``peer``, in order.

        PENDING_ACK comes first if the command needs the sensor's bus and its sender is a controller
        that understands it.
        """
        command = gvcp.parse_command(data)
        if command is None:
            return []
        now = time.monotonic() if now is None else now
        with self._lock:
            self.tick(now)
            before = self._registers.bus_accesses
            self._confirmed |= peer == self.controller
            answer = self._answer(command, peer)
            slow = self._registers.bus_accesses != before
            if peer == self.controller:         # since this command, perhaps
                self._heard = now
            if answer is None:
                return []
            pending = (slow and peer == self.controller
                       and self._words[gvcp.register("Configuration").address])
            return [gvcp.pending_acknowledge(command), answer] if pending else [answer]

    def _answer(self, command, peer):
        action = self._commands.get(command.code)
        if action is None:
            # Datagrams that are no commands at all are not worth an answer.
            known = command.code % 2 == 0 and command.answered
            return gvcp.acknowledge(command, gvcp.NOT_IMPLEMENTED) if known else None
        try:
            answer = action(command.payload, peer)
        except _Status as error:
            return gvcp.acknowledge(command, error.status) if command.answered else None
        if answer is None or not command.answered:
            return None
        return gvcp.acknowledge(command, gvcp.SUCCESS, answer)

    def tick(self, now):
        """Take control from a controller that has not been heard of for the heartbeat's time.

        One datagram may have a forged sender: until there is a second one, it is not the time that
        the first one asks for, if that is longer than the default.
        """
        timeout = self._words[gvcp.register("HeartbeatTimeout").address] / 1000
        if not self._confirmed:
            timeout = min(timeout, gvcp.HEARTBEAT_MS / 1000)
        with self._lock:
            if self.controller is not None and now - self._heard > timeout:
                self._release()

    def _release(self):
        self._stream.stop()
        self.controller, self._confirmed = None, False
        self._tl_locked, self._acquiring, self._mode, self._trigger = 0, False, 0, 0
        self._registers.streaming = self._registers.controlled = False
        for name, value in (("HeartbeatTimeout", gvcp.HEARTBEAT_MS), ("ControlPrivilege", 0),
                            ("Configuration", 0), ("StreamPort", 0), ("StreamPacketDelay", 0),
                            ("StreamAddress", 0),
                            ("StreamPacketSize",
                             gvcp.SCPS_DO_NOT_FRAGMENT | gvsp.packet_size(1500)),
                            ("StreamSourcePort", self._stream.port), ("TimestampControl", 0),
                            ("TimestampHigh", 0), ("TimestampLow", 0)):
            self._words[gvcp.register(name).address] = value

    def _discovery(self, payload, peer):
        return self._memory(0, gvcp.DISCOVERY_BYTES)

    def _forceip(self, payload, peer):
        if len(payload) != gvcp.FORCE_IP.size:
            raise _Status(gvcp.INVALID_HEADER)
        mac_high, mac_low, address, _, _ = gvcp.FORCE_IP.unpack(payload)
        if mac_high << 32 | mac_low != self._identity.mac:
            return None
        if self.controller is not None:
            raise _Status(gvcp.ACCESS_DENIED)
        # The address is this machine's, which the device cannot change.
        if address not in (0, int(IPv4Address(self._identity.address))):
            raise _Status(gvcp.INVALID_PARAMETER)
        return b""

    def _readreg(self, payload, peer):
        if not payload or len(payload) % 4 or len(payload) > 4 * gvcp.REGISTERS_MAX:
            raise _Status(gvcp.INVALID_HEADER)
        return b"".join(self._memory(address, 4, peer)
                        for address, in struct.iter_unpack(">I", payload))

    def _writereg(self, payload, peer):
        if not payload or len(payload) % 8 or len(payload) > 4 * gvcp.REGISTERS_MAX:
            raise _Status(gvcp.INVALID_HEADER)
        count = 0
        for address, value in struct.iter_unpack(">II", payload):
            self._write(address, value, peer)
            count += 1
        return struct.pack(">HH", 0, count)

    def _readmem(self, payload, peer):
        if len(payload) != 8:
            raise _Status(gvcp.INVALID_HEADER)
        address, _, count = struct.unpack(">IHH", payload)
        if not 4 <= count <= gvcp.MEMORY_BYTES_MAX:
            raise _Status(gvcp.INVALID_PARAMETER)
        return payload[:4] + self._memory(address, count, peer)

    def _writemem(self, payload, peer):
        if not 8 <= len(payload) <= 4 + gvcp.MEMORY_BYTES_MAX or len(payload) % 4:
            raise _Status(gvcp.INVALID_HEADER)
        address, = struct.unpack_from(">I", payload)
        for k, (value,) in enumerate(struct.iter_unpack(">I", payload[4:])):
            self._write(address + 4 * k, value, peer)
        return struct.pack(">HH", 0, len(payload) - 4)

    def _packetresend(self, payload, peer):
        if len(payload) < 12:
            return None
        _, block, first, last = struct.unpack_from(">HHII", payload)
        first, last = first & 0xFFFFFF, last & 0xFFFFFF
        # A receiver asks from a socket of its own, perhaps, but from the controller's machine.
        # A request for what is not stored gets no answer: packets are the answer.
        if self.controller is None or peer[0] != self.controller[0]:
            return None
        then, budget = self._resend_budget
        now = time.monotonic()
        budget = min(_RESENT_PER_SECOND, budget + (now - then) * _RESENT_PER_SECOND)
        wanted = min(last - first + 1, 1 << 16)
        if first > last or wanted > budget:
            return None
        self._resend_budget = (now, budget - wanted)
        self._stream.resend(block, first, last)
        return None

    # Memory.

    def _memory(self, address, count, peer=None):
        """``count`` bytes from ``address`` on, both whole words, as ``peer`` may see them."""
        if address % 4 or count % 4:
            raise _Status(gvcp.BAD_ALIGNMENT)
        if gvcp.XML_BASE <= address < gvcp.XML_BASE + len(self._xml):
            # A client may read beyond the end to fill its last packet.
            part = self._xml[address - gvcp.XML_BASE:][:count]
            return part.ljust(count, b"\0")
        return b"".join(self._word(at, peer).to_bytes(4, "big")
                        for at in range(address, address + count, 4))

    def _word(self, address, peer):
        if address < gvcp.FEATURE_BASE:
            for start, text in self._texts.items():
                if start <= address < start + len(text):
                    return int.from_bytes(text[address - start:address - start + 4], "big")
            if address == _SOURCE_PORT and peer != self.controller:
                return 0        # who knows it can send pictures in this device's name
            if address in self._words:
                return self._words[address]
            if address < gvcp.DISCOVERY_BYTES:
                return 0        # reserved words of the discovery acknowledge
        if address in self._features:
            return self._read_feature(self._features[address])
        if gvcp.CORRECTOR_BASE <= address < gvcp.CORRECTOR_BASE + gvcp.CORRECTOR_BYTES:
            return self._corrector.read((address - gvcp.CORRECTOR_BASE) // 4)
        raise _Status(gvcp.INVALID_ADDRESS)

    def _read_feature(self, one):
        if one.parts:
            return self._registers.read_feature(one)
        if one.name == "PayloadSize":
            return self._registers.settings.view.size
        if one.name == "SensorRegisterValue":
            return self._registers.read(self._sensor_address)
        if one.name == "BalanceRatio":
            return self._registers.settings.colour.raw_gains[self._ratio]
        return {**self._registers.auto,
                "AcquisitionMode": self._mode, "TriggerMode": self._trigger,
                "TLParamsLocked": self._tl_locked, "BalanceRatioSelector": self._ratio,
                "SensorRegisterAddress": self._sensor_address}.get(one.name, 0)

    def _write(self, address, value, peer):
        if address % 4:
            raise _Status(gvcp.BAD_ALIGNMENT)
        if address == gvcp.register("ControlPrivilege").address:
            self._write_control(value, peer)
            return
        # Another client must not learn from a write what is there.
        if peer != self.controller:
            raise _Status(gvcp.ACCESS_DENIED)
        one = self._features.get(address)
        corrector = gvcp.CORRECTOR_BASE <= address < gvcp.CORRECTOR_BASE + gvcp.CORRECTOR_BYTES
        if one is None and not corrector and address not in self._writable:
            self._memory(address, 4)        # rejects an address where there is nothing
            raise _Status(gvcp.WRITE_PROTECT)
        try:
            if one is not None:
                self._write_feature(one, value)
            elif corrector:
                self._corrector.write((address - gvcp.CORRECTOR_BASE) // 4, value)
            else:
                self._write_bootstrap(address, value)
        except Rejected as error:
            raise _Status(_STATUS[error.reason]) from None

    def _write_control(self, value, peer):
        if self.controller not in (None, peer):
            raise _Status(gvcp.ACCESS_DENIED)
        if value & ~(gvcp.CCP_EXCLUSIVE | gvcp.CCP_CONTROL):
            raise _Status(gvcp.INVALID_PARAMETER)
        if value == 0:
            self._release()
            return
        self.controller = peer
        self._registers.controlled = True
        self._words[gvcp.register("ControlPrivilege").address] = value

    def _write_bootstrap(self, address, value):
        name = self._writable[address]
        if name == "HeartbeatTimeout":
            value = min(max(value, gvcp.HEARTBEAT_MIN_MS), gvcp.HEARTBEAT_MAX_MS)
        elif name == "Configuration" and value & ~gvcp.CONFIGURATION_PENDING_ACK:
            raise Rejected("value")
        elif name == "StreamPort" and value > 0xFFFF:
            raise Rejected("value")
        elif name == "StreamPacketDelay" and value > feature("GevSCPD").high:
            raise Rejected("value")
        elif name == "StreamPacketSize":
            if not gvsp.MIN_PACKET <= value & 0xFFFF <= gvsp.MAX_PACKET:
                raise Rejected("value")
            asked, size = value & 0xFFFF, gvsp.packet_size(value & 0xFFFF)
            if self._acquiring and size != self._words[address] & 0xFFFF:
                raise Rejected("locked")
            self._words[address] = size | value & gvcp.SCPS_DO_NOT_FRAGMENT
            if value & gvcp.SCPS_FIRE and (receiver := self._receiver()) is not None:
                self._stream.fire_test(replace(receiver, packet_size=asked))
            return
        elif name == "TimestampControl":
            if value & 2:
                now = self._camera.now_ns()
                self._words[gvcp.register("TimestampHigh").address] = now >> 32
                self._words[gvcp.register("TimestampLow").address] = now & 0xFFFFFFFF
            return
        if (self._acquiring and name in ("StreamPort", "StreamAddress")
                and value != self._words[address]):
            raise Rejected("locked")
        self._words[address] = value

    def _write_feature(self, one, value):
        if one.access == "ro":
            raise Rejected("read only")
        if one.parts:
            self._registers.write_feature(one, value)
            return
        if not one.low <= value <= one.high:
            raise Rejected("value")
        if one.name in self._registers.auto:
            self._registers.auto[one.name] = value
        elif one.name == "BalanceRatioSelector":
            self._ratio = value
        elif one.name == "BalanceRatio":
            self._registers.set_ratio(self._ratio, value)
        elif one.name == "AcquisitionMode":
            if self._acquiring:
                raise Rejected("locked")
            if value not in {choice.value for choice in one.choices}:
                raise Rejected("value")
            self._mode = value
        elif one.name == "TriggerMode":
            if self._acquiring and value != self._trigger:
                raise Rejected("locked")
            self._trigger = value
        elif one.name == "TriggerSoftware" and value:
            self._stream.trigger()
        elif one.name == "TLParamsLocked":
            self._tl_locked = value
            self._registers.streaming = bool(value) or self._acquiring
        elif one.name == "AcquisitionStart" and value:
            self._start()
        elif one.name == "AcquisitionStop" and value:
            self._stop()
        elif one.name == "SensorRegisterAddress":
            self._sensor_address = value
        elif one.name == "SensorRegisterValue":
            self._registers.write(self._sensor_address, value)

    def _receiver(self):
        words = {name: self._words[gvcp.register(name).address] for name in (
            "StreamPort", "StreamAddress", "StreamPacketSize", "StreamPacketDelay")}
        address = IPv4Address(words["StreamAddress"])
        # Pictures go to the controller's machine only, or to a group.
        if not words["StreamPort"] or not (address.is_multicast
                                           or str(address) == self.controller[0]):
            return None
        size = words["StreamPacketSize"]
        return Receiver((str(address), words["StreamPort"]),
                        size & 0xFFFF, words["StreamPacketDelay"],
                        not size & gvcp.SCPS_DO_NOT_FRAGMENT)

    def _start(self):
        receiver = self._receiver()
        if self._acquiring:
            return
        if receiver is None:
            raise Rejected("locked")     # no receiver
        self._acquiring = self._registers.streaming = True
        self._stream.start(receiver, single=self._mode == 1, done=self._ended,
                           triggered=self._trigger == 1)

    def _stop(self):
        self._stream.stop()
        self._ended()

    def _ended(self):
        self._acquiring = False
        self._registers.streaming = bool(self._tl_locked)
