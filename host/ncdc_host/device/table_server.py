"""Table I and II of an emulated device over TCP."""

import threading

from ncdc_host.device.registers import Rejected
from ncdc_spec.protocols import table_one, table_users
from ncdc_spec.protocols.features import system_word
from ncdc_spec.protocols.table_two import MrawHeader

__all__ = ["TableServer"]

_NUMBER = (system_word("NUMBER_UPPER"), system_word("NUMBER_LOWER"))


class TableServer(table_users.TableServer):
    """Serves the words of ``registers`` and the pictures of ``camera`` until it is closed.

    Parameters: ``registers`` : Registers, ``camera`` : Camera, others as of the base class.
    """

    def __init__(self, registers, camera, address, port):
        self._registers, self._camera, self._address = registers, camera, address
        super().__init__(address, port, table_one.server_settings(), registers.lock)
        threading.Thread(target=self.serve, daemon=True).start()

    def read(self, user, address):
        """The word of an address; the number of the frame is that of the user's last one."""
        if address in _NUMBER:
            return user.frame >> (16 if address == _NUMBER[0] else 0) & 0xFFFF
        return self._registers.read(address)

    def write(self, address, value):
        """Write a word, if it can be written."""
        try:
            self._registers.write(address, value)
        except Rejected:
            pass        # the answer says so: it differs from the request

    def package(self, user):
        """Header and data of the newest picture."""
        frame = self._camera.newest()
        user.frame = frame.number
        width, height = frame.size
        return MrawHeader(width, height, frame.pixel_format, self._address, self.port,
                          frame.time_ns // 1000).pack(), frame.data
