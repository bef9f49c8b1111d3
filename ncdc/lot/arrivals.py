"""Units of a station, as their photos arrive in a folder."""

import os
import time

from ncdc.lot.units import Unit
from ncdc_model.photo.names import may_be_photo, natural
from ncdc_spec.errors import InputError

__all__ = ["Arrivals"]


class Arrivals:
    """Looks at a folder again and again: which of the folders in it is a new, complete unit.

    A unit is complete if its folder has ``count`` photos or more, and no name, size or time of
    modification in it has changed for ``settle`` seconds. Folders whose name begins with a dot
    are none: a folder that gets its name when all photos are in it is never taken too early.

    Attributes
    ----------
    waiting : dict
        Number of photos of each folder that is not complete yet.
    problems : dict
        A sentence on each folder that cannot be a unit, and on ``folder`` itself if it cannot be
        read.

    Parameters
    ----------
    folder : str
    count : int
    settle : float
    clock : callable
        Seconds, never backwards.

    Raises
    ------
    InputError
        If the folder cannot be read.
    """

    def __init__(self, folder, count=1, settle=2.0, clock=time.monotonic):
        self.folder, self.count, self.settle, self.clock = folder, count, settle, clock
        self.waiting, self.problems = {}, {}
        self._taken = set()         # names that are units of the lot
        self._seen = {}             # by name: content of the folder, and since when
        try:
            os.listdir(folder)
        except OSError as error:
            raise InputError(f"cannot read {folder}: {error.strerror}") from error

    def __call__(self, known):
        """List of new :class:`Unit`.

        ``known``: function that gives those of some serial numbers that are units of the lot.
        """
        waiting, problems, units = {}, {}, []
        try:
            with os.scandir(self.folder) as entries:
                names = {entry.name for entry in entries
                         if entry.name[0] != "." and entry.is_dir()}
        except OSError as error:
            self.problems = {self.folder: f"cannot read {self.folder}: {error.strerror}"}
            return []
        self._taken &= names
        new = sorted(names - self._taken, key=natural)
        self._taken |= known(new)
        for name in new:
            if name not in self._taken:
                try:
                    units += self._unit(name, waiting)
                except InputError as error:
                    problems[name] = str(error)
                except FileNotFoundError:
                    self._seen.pop(name, None)      # a file gets its name at this moment
                except OSError as error:
                    problems[name] = f"cannot read {name}: {error.strerror}"
        self._seen = {name: seen for name, seen in self._seen.items() if name in waiting}
        self.waiting, self.problems = waiting, problems
        return units

    def _unit(self, name, waiting):
        """List of the unit in the folder ``name``; empty, and noted in ``waiting``, if it is not
        complete."""
        Unit(name, ())              # a name that is no serial number is rejected before any photo
        with os.scandir(os.path.join(self.folder, name)) as entries:
            content = {entry.name: (about.st_size, about.st_mtime_ns) for entry in entries
                       if (about := entry.stat(follow_symlinks=True))}
        photos = sorted(filter(may_be_photo, content), key=natural)
        now = self.clock()
        if self._seen.get(name, (None,))[0] != content:
            self._seen[name] = content, now
        if len(photos) < self.count or now - self._seen[name][1] < self.settle:
            waiting[name] = len(photos)
            return []
        folder = os.path.abspath(self.folder)
        return [Unit(name, tuple(os.path.join(folder, name, photo) for photo in photos))]
