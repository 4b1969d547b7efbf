"""Files that a robot's description names: meshes beside it, in packages, anywhere; and xacro made plain."""

from __future__ import annotations

import stat
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from xml.sax.saxutils import escape

from mobo_core.errors import InputError

MAX_ROBOT_BYTES = 10_000_000
MAX_MESH_BYTES = 100_000_000
_XACRO = "http://www.ros.org/wiki/xacro", "http://wiki.ros.org/xacro", "http://ros.org/wiki/xacro"


class Packages:
    """Finds what a description names.

    Args:
        description: file of the robot; packages are looked for in its folder and all those above it.
        folders: more folders that hold packages, or are one, searched first.
    """

    def __init__(self, description: Path, folders: Sequence[str] = ()) -> None:
        for folder in folders:
            if not Path(folder).is_dir():
                raise InputError("no such folder", where=f"--package-dir {folder}", expected="a folder with packages")
        self._beside = _absolute(description).parent
        self._folders = [_absolute(Path(folder)) for folder in folders]
        self._folders += [self._beside, *self._beside.parents]

    def folder(self, package: str) -> Path:
        """Return the folder of a package.

        Raises:
            InputError: it is in none of the folders.
        """
        if package and "/" not in package and package not in (".", ".."):
            for folder in self._folders:
                if folder.name == package or _package_name(folder) == package:
                    return folder
                if (folder / package).is_dir():
                    return folder / package
        expected = f"its folder in one of {self._beside} and those above, or --package-dir"
        raise InputError(f"package {package[:60]!r} is not found", where="robot", expected=expected)

    def file(self, name: str) -> Path:
        """Return the file that ``package://NAME/…``, ``model://…``, ``file://…`` or a path beside the robot names.

        Raises:
            InputError: there is no such file, or it is none.
        """
        where = f"mesh {name[-80:]!r}"
        if not name or "\0" in name:
            raise InputError("no name of a file", where=where, expected="a path")
        scheme, _, rest = name.rpartition("://")
        if scheme in ("package", "model"):
            package, _, below = rest.partition("/")
            path = self._folder_at(package, where) / below
        elif scheme in ("", "file"):
            path = self._beside / rest
        else:
            raise InputError(f"scheme {scheme[:20]}://", where=where, expected="package://, file:// or a path")
        try:
            mode = path.stat().st_mode
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            expected = "a file (--package-dir names folders)"
            raise InputError(f"{path}: {reason}", where=where, expected=expected) from None
        if not stat.S_ISREG(mode):
            raise InputError(f"{path} is no file", where=where, expected="a mesh file")
        return path

    def _folder_at(self, package: str, where: str) -> Path:
        try:
            return self.folder(package)
        except InputError as error:
            raise InputError(error.what, where=where, expected=error.expected) from None


def _absolute(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError) as error:  # links in a circle
        raise InputError(str(error), where=str(path), expected="a path without circles") from None


def _package_name(folder: Path) -> str:
    try:
        text = (folder / "package.xml").read_bytes()[:10_000].decode("utf-8", "replace")
    except OSError:
        return ""
    return text.partition("<name>")[2].partition("</name>")[0].strip()


def read_description(path: str, packages: Packages, arguments: Mapping[str, str]) -> bytes:
    """Return a robot's description; a xacro file is expanded with ``arguments``.

    Raises:
        InputError: it cannot be read, is too large, or xacro refuses it.
    """
    try:
        with Path(path).open("rb") as file:
            data = file.read(MAX_ROBOT_BYTES + 1)
    except OSError as error:
        raise InputError(error.strerror or str(error), where="file", expected="a URDF file") from None
    if len(data) > MAX_ROBOT_BYTES:
        raise InputError(f"more than {MAX_ROBOT_BYTES} bytes", where="file", expected="a URDF file")
    if path.endswith(".xacro") or any(f'"{name}"'.encode() in data for name in _XACRO):
        return _expanded(path, packages, arguments)
    if arguments:
        raise InputError("--xacro for a file that is no xacro", where="arguments", expected="a .xacro file")
    return data


def _expanded(path: str, packages: Packages, arguments: Mapping[str, str]) -> bytes:
    import xacro

    with _finding(packages):
        try:
            document = xacro.process_file(path, mappings=dict(arguments))
            text: str = document.toxml()
        except RecursionError:
            what = "includes itself, or is nested too deep"
            raise InputError(what, where="xacro", expected="a finite file") from None
        except InputError as error:
            raise error.at("xacro") from None
        except Exception as error:  # xacro evaluates expressions: any may come
            raise InputError(f"{type(error).__name__}: {escape(str(error))[:300]}", where="xacro") from None
    return text.encode()


@contextmanager
def _finding(packages: Packages) -> Iterator[None]:
    """Have xacro's ``$(find PACKAGE)`` look where we do, and then where it does."""
    from xacro import substitution_args

    usual = substitution_args._eval_find

    def find(package: str) -> str:
        try:
            return str(packages.folder(package))
        except InputError as missing:
            try:
                found: str = usual(package)
            except Exception:
                raise missing from None
            return found

    tables = [substitution_args._eval_dict] if hasattr(substitution_args, "_eval_dict") else []
    substitution_args._eval_find = find
    for table in tables:
        table["find"] = find
    try:
        yield
    finally:
        substitution_args._eval_find = usual
        for table in tables:
            table["find"] = usual
