"""The bag of a running study: opened new or continued, appended to, closed."""

from __future__ import annotations

import contextlib
import errno
import os
from dataclasses import replace
from pathlib import Path

from mobo_core.bag.blank import clear_blank, is_blank
from mobo_core.bag.chain import beginning
from mobo_core.bag.collector import past_study
from mobo_core.bag.files import FileSummary, write_metadata
from mobo_core.bag.lock import LOCK_FILE, BagLock
from mobo_core.bag.reader import FileContent, read_record
from mobo_core.bag.record import StudyRecord, schema_version_of, settings_of, study_record
from mobo_core.bag.recover import recover_file
from mobo_core.bag.writer import Create, McapFile, create_file, custom_data, next_file
from mobo_core.errors import InputError
from mobo_core.messages import SCHEMA_VERSION, Candidate, Message, encode
from mobo_core.search.study import StudySettings

# The index of a file is held in memory until the file is finished: at most some 8 MB of it.
_MAX_CHUNKS = 20_000


class StudyBag:
    """Appends the messages of a study to its bag; each is flushed before the call returns.

    Args:
        folder: of the bag.
        name: of the study.
        settings: what the study's trials depend on.
        resume: continue the bag if it exists.
        node: name of the optimizer, for the lock.
        prefix: of the topic names, ``/`` or a namespace.
        create: makes the files.

    Raises:
        InputError: the bag exists and ``resume`` is false; it is of another study or other settings; it is no
            bag, or no folder that can be written. Nothing is changed then.
        InUseError: another optimizer writes to it.
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        settings: StudySettings,
        *,
        resume: bool,
        node: str = "optimizer",
        prefix: str = "/",
        create: Create = create_file,
    ) -> None:
        self.folder, self.name, self.settings, self._prefix = folder, name, settings, prefix
        self._create = create
        self._files: list[FileSummary] = []  # those that are whole
        self._file: McapFile | None = None
        self._digest = ""  # of the last of them
        self._past: StudyRecord | None = None
        _check(folder, name, settings, resume=resume)
        try:
            self._lock: BagLock | None = BagLock(folder, node, make=True)
        except OSError as error:
            raise _not_writable(folder, error) from None
        try:
            # Again: another optimizer may have been faster.
            recorded = _check(folder, name, settings, resume=resume)
            self._new = recorded is None
            if recorded is not None:
                self.settings = recorded
            if self._new:
                clear_blank(folder)
        except BaseException:
            self._lock.release()
            raise
        self._version = SCHEMA_VERSION if self._new else schema_version_of(read_record(folder), str(folder))
        self._record = study_record(name, self.settings, self._version)

    def past(self) -> StudyRecord | None:
        """Return what the bag holds of the study, as :func:`past_study` does; None if it is new. Touches nothing.

        It is read once, and kept until :meth:`go_on`.

        Raises:
            InputError: a file of the bag cannot be read.
        """
        if self._past is None and not self._new:
            self._past = past_study(self.folder)
        return self._past

    def go_on(self, past: StudyRecord) -> None:
        """Make whole the files whose writer was killed; call it before anything is appended to :meth:`past`.

        Raises:
            StudyError: no room to make a file whole; it is as it was.
        """
        self._past = None
        for i, content in enumerate(past.contents):
            next_says = past.contents[i + 1].chain.get("previous", "") if i + 1 < len(past.contents) else ""
            whole = content if content.finished else self._recover(content, next_says)
            self._files.append(whole.summary)
            self._digest = whole.digest

    def _recover(self, content: FileContent, next_says: str) -> FileContent:
        return recover_file(content, self._record, self._digest, next_says, self._create)

    def note(self, **values: object) -> None:
        """Put more into the record that the files of this session begin with."""
        self._record |= {name: str(value) for name, value in values.items()}

    @property
    def recording(self) -> bool:
        """Whether this session has written anything."""
        return self._file is not None

    def append(self, topic: str, message: Message) -> bytes:
        """Append a message to a topic (relative name), flush, and return its CDR bytes as they are sent."""
        data = encode(message)
        self.append_raw(topic, message.kind, data if self._version == SCHEMA_VERSION else self._as_older(message))
        return data

    def _as_older(self, message: Message) -> bytes:
        """Return a message in the schema that the bag began with: readers take one definition a type."""
        if isinstance(message, Candidate):
            message = replace(message, schema_version=self._version)
        return encode(message, self._version)

    def append_raw(self, topic: str, kind: str, data: bytes) -> None:
        """Append CDR bytes as they came."""
        if self._file is not None and self._file.n_chunks >= _MAX_CHUNKS:
            self._file.finish()
            self._files.append(self._file.summary)
            self._digest, self._file = self._file.digest, None
        if self._file is None:
            chain = beginning("recorded", self._digest)
            self._file = McapFile(
                next_file(self.folder), self._record, version=self._version, chain=chain, create=self._create
            )
        self._file.write(self._prefix + topic, kind, data)

    def close(self) -> None:
        """Finish the file, write metadata.yaml, release the lock. May be called twice.

        Raises:
            StudyError: no room for it; all that was appended stays.
        """
        if self._lock is None:
            return
        lock, self._lock = self._lock, None
        try:
            if self._file is not None:
                self._files.append(self._file.summary)
                self._file.finish()
            if self._files:
                write_metadata(self.folder, self._files, custom_data(self._record))
            elif self._new:
                with contextlib.suppress(OSError):
                    (self.folder / LOCK_FILE).unlink(missing_ok=True)
                    os.rmdir(self.folder)  # nothing was recorded: leave nothing behind
        finally:
            lock.release()


def check_new(folder: Path) -> None:
    """See that a study may begin in a folder: there is none, or nothing has come of what is in it.

    Raises:
        InputError: it may not.
    """
    if _holds_something(folder) and not is_blank(folder):
        expected = "resume:=true, or the name of a new bag"
        raise InputError("exists already", where=str(folder), expected=expected)


def check_writable(folder: Path) -> None:
    """See that a bag can be written in a folder, which is made for a moment if there is none.

    Raises:
        InputError: it cannot be made or written to.
    """
    made: list[Path] = []
    try:
        for path in reversed([path for path in (folder, *folder.parents) if not path.exists()]):
            path.mkdir(exist_ok=True)
            made.append(path)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    except OSError as error:
        raise _not_writable(folder, error) from None
    finally:
        with contextlib.suppress(OSError):  # somebody else's by now
            for path in reversed(made):
                path.rmdir()


def _not_writable(folder: Path, error: OSError) -> InputError:
    expected = "a folder that can be made and written to"
    return InputError(error.strerror or str(error), where=str(folder), expected=expected)


def recorded_study(folder: Path) -> tuple[str, StudySettings] | None:
    """Return name and settings of the study that a bag holds; None if it does not exist.

    Raises:
        InputError: what is there is no bag of a study.
    """
    if not _holds_something(folder):
        return None
    record = read_record(folder)
    if not record and is_blank(folder):
        return None  # its writer was killed before it had said what it is
    return record.get("study", ""), settings_of(record, str(folder))


def _holds_something(folder: Path) -> bool:
    try:
        return folder.exists() and any(entry.name != LOCK_FILE for entry in folder.iterdir())
    except OSError as error:
        expected = "a folder that can be read and written"
        raise InputError(str(error.strerror), where=str(folder), expected=expected) from None


def _check(folder: Path, name: str, settings: StudySettings, *, resume: bool) -> StudySettings | None:
    """Return the settings of the bag to go on with, if there is one; errors as :class:`StudyBag`."""
    if not resume:
        check_new(folder)
        return None
    recorded = recorded_study(folder)
    if recorded is None:
        return None
    _same_study(*recorded, name, settings, str(folder))
    return recorded[1]


def _same_study(its_name: str, recorded: StudySettings, name: str, settings: StudySettings, where: str) -> None:
    if its_name != name:
        raise InputError(f"holds study {its_name!r}", where=where, expected=f"study {name!r}")
    if "" in (recorded.engine, settings.engine):  # whichever: what its candidates say holds
        settings = settings.model_copy(update={"engine": recorded.engine})
    difference = recorded.first_difference(settings)
    if difference:
        setting, old, new = difference
        raise InputError(f"{setting} is {old!r} in the bag", where=where, expected=f"{new!r}, as asked for now")
