"""A simulated disk below a real folder: it fills up, writes in pieces, and a process may die amid a write."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from random import Random
from typing import BinaryIO

from mobo_core.bag.writer import NewFile
from mobo_core.simulate.violation import KilledError


class Disk:
    """What the files of one host lie on.

    Args:
        random: where chance comes from.

    Attributes:
        full: whether nothing more fits.
        short: whether writes take a part of what they are given.
        torn: whether the next write is one in which its process dies.
    """

    def __init__(self, random: Random) -> None:
        self.random = random
        self.full = self.short = self.torn = False
        self._left: dict[Path, bytes] = {}
        self._files: list[BinaryIO] = []

    def create(self, path: Path) -> NewFile:
        """Make a file, as :data:`mobo_core.bag.writer.Create` says."""
        if self.full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        file = path.open("xb", buffering=0)
        self._files.append(file)
        return _File(self, path, file)

    def write(self, path: Path, file: BinaryIO, data: bytes) -> int:
        """Write as much as the disk lets."""
        if self.torn:
            self.torn = False
            file.write(data[: int(len(data) * self.random.random())])
            # What a dying process leaves behind stays, whatever Python does on the way out.
            self._left = {part: part.read_bytes() for part in path.parent.glob("*.recovering")}
            raise KilledError
        if self.full:
            part = data[: int(len(data) * self.random.random())]
            if not part:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            return file.write(part)
        if self.short and len(data) > 1:
            return file.write(data[: max(1, int(len(data) * self.random.random()))])
        return file.write(data)

    def bury(self) -> None:
        """Close what a process that has ended held open, and leave what it left."""
        for file in self._files:
            file.close()
        self._files.clear()
        for path, data in self._left.items():
            path.write_bytes(data)
        self._left = {}

    def lose_tail(self, folder: Path) -> None:
        """Let a bag's last file lose some of its end, as when the power fails before the disk has it all."""
        files = sorted(folder.glob("*.mcap"), key=lambda path: int(path.stem.rsplit("_", 1)[1]))
        if files:
            size = files[-1].stat().st_size
            os.truncate(files[-1], size - int(min(size, 8_000) * self.random.random()))


class _File:
    def __init__(self, disk: Disk, path: Path, file: BinaryIO) -> None:
        self._disk, self._path, self._file = disk, path, file

    def write(self, data: bytes, /) -> int:
        return self._disk.write(self._path, self._file, data)

    def truncate(self, size: int, /) -> int:
        return self._file.truncate(size)

    def fileno(self) -> int:
        return self._file.fileno()

    def close(self) -> None:
        self._file.close()
