"""A small stand-in for the command ``ros2``: ``ros2 run`` and ``ros2 pkg executables``.

ROS 2 from Python wheels comes without that command. Where there is a real ``ros2`` after all, this one hands
over to it; what it does not offer it says, rather than doing something similar.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NoReturn

NAME = "mobo_ros2_standin"
RUN_USAGE = "ros2 run PKG EXE [ARGS]"
PKG_USAGE = "ros2 pkg executables [PKG] [--full-path]"
HELP = f"""\
A stand-in for the real ros2, on machines that have ROS 2 as Python wheels only. It offers:

  {RUN_USAGE:<41} run an executable of a package
  {PKG_USAGE:<41} list what can be run"""
SYSTEM_ROS = Path("/opt/ros/jazzy")
_MARKERS = Path("share/ament_index/resource_index/packages")


class StandinError(Exception):
    """What was asked for cannot be done; the message says why in one line."""


def prefixes() -> list[Path]:
    """Return the folders of ``AMENT_PREFIX_PATH``, the first taking precedence."""
    folders = [Path(folder) for folder in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if folder]
    if not folders:
        raise StandinError("AMENT_PREFIX_PATH is not set; source install/setup.bash first")
    return folders


def packages() -> dict[str, Path]:
    """Return each package of the ament index with the prefix it is installed in."""
    found: dict[str, Path] = {}
    for prefix in prefixes():
        for marker in sorted((prefix / _MARKERS).glob("[!.]*")):
            found.setdefault(marker.name, prefix)
    return found


def prefix_of(package: str) -> Path:
    """Return the prefix that ``package`` is installed in."""
    known = packages()
    if package not in known:
        # A wheels-only machine has a hundred message packages; only those with something to run help here.
        runnable = [name for name, prefix in known.items() if any(executables(prefix, name))]
        raise StandinError(f"package {package!r} not found; packages with executables: {_listed(runnable)}")
    return known[package]


def executables(prefix: Path, package: str) -> Iterator[Path]:
    """Yield the executable files below ``prefix/lib/package``."""
    for folder, subfolders, files in os.walk(prefix / "lib" / package):
        subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))
        for name in sorted(files):
            path = Path(folder, name)
            if os.access(path, os.X_OK):
                yield path


def run(package: str, executable: str, args: list[str]) -> NoReturn:
    """Become the executable: its exit code, its signals and its terminal are then its own."""
    installed = list(executables(prefix_of(package), package))
    matches = [path for path in installed if path.name == executable]
    if not matches:
        names = _listed(path.name for path in installed)
        raise StandinError(f"no executable {executable!r} in package {package!r}; there are: {names}")
    if len(matches) > 1:
        raise StandinError(f"several executables {executable!r} in package {package!r}: {_listed(matches)}")
    if package == "mobo":
        # Ctrl-C while the next Python starts would print where it was; mobo's nodes let it through again.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    _become([str(matches[0]), *args])


def list_executables(package: str | None, full_path: bool) -> None:
    """Print ``PKG EXE`` or the full path, a line for each executable."""
    chosen = {package: prefix_of(package)} if package else packages()
    for name in sorted(chosen):
        for path in executables(chosen[name], name):
            print(path if full_path else f"{name} {path.name}")


def real_ros2() -> list[str] | None:
    """Return the command line that starts a real ``ros2``, or None if this machine has none."""
    for folder in os.get_exec_path():
        candidate = shutil.which("ros2", path=folder)
        if candidate and not _is_standin(Path(candidate)):
            return [candidate]
    command = SYSTEM_ROS / "bin" / "ros2"
    setup = SYSTEM_ROS / "setup.bash"
    if not os.access(command, os.X_OK):
        return None
    if not setup.is_file():
        return [str(command)]
    # Not on PATH, so not sourced: without its environment it would not find its own modules.
    return ["bash", "-c", '. "$1"; shift; exec "$@"', "bash", str(setup), str(command)]


def main(argv: list[str] | None = None) -> int:
    """Run the command ``ros2`` and return its exit code."""
    argv = sys.argv[1:] if argv is None else argv
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        real = real_ros2()
        if real:
            _become([*real, *argv], leave_wheels=True)
        return _dispatch(argv)
    except StandinError as error:
        print(f"ros2: {error}", file=sys.stderr)
        return 2


def _dispatch(argv: list[str]) -> int:
    match argv:
        case [] | [*_, "-h" | "--help"] if len(argv) <= 2 or argv[0] == "pkg":
            print(HELP)
        case ["run", package, executable, *args]:
            run(package, executable, args)
        case ["pkg", "executables", *options]:
            names = [option for option in options if option != "--full-path"]
            if len(names) > 1 or any(name.startswith("-") for name in names):
                raise StandinError(f"got {' '.join(argv)!r}, expected: {PKG_USAGE}")
            list_executables(names[0] if names else None, full_path="--full-path" in options)
        case ["run", *_]:
            raise StandinError(f"got {' '.join(argv)!r}, expected: {RUN_USAGE}")
        case [*verb]:
            asked = " ".join(verb[:2] if verb[0] == "pkg" else verb[:1])
            offers = f"{RUN_USAGE}, {PKG_USAGE}"
            raise StandinError(f"no verb {asked!r} in this stand-in for the real ros2; it offers: {offers}")
    return 0


def _is_standin(command: Path) -> bool:
    # Told by its text rather than its path: two environments with a stand-in each would hand over for ever.
    try:
        with command.open("rb") as file:
            return NAME.encode() in file.read(4096)
    except OSError:
        return True


def _become(command: list[str], *, leave_wheels: bool = False) -> NoReturn:
    environment = dict(os.environ)
    if leave_wheels and "_ROS_WHEELS_BOOTSTRAP_COMPLETE" in environment:
        # What the start-up of the wheels' Python set would give the real ros2 their libraries.
        del environment["_ROS_WHEELS_BOOTSTRAP_COMPLETE"]
        kept = [
            folder
            for folder in environment.get("LD_LIBRARY_PATH", "").split(os.pathsep)
            if folder and not Path(folder).is_relative_to(sys.prefix)
        ]
        environment["LD_LIBRARY_PATH"] = os.pathsep.join(kept)
    sys.stdout.flush()
    try:
        os.execvpe(command[0], command, environment)
    except OSError as error:
        raise StandinError(f"cannot start {command[0]}: {error.strerror}") from None


def _listed(items: Iterable[object]) -> str:
    return ", ".join(str(item) for item in items) or "none"


if __name__ == "__main__":
    sys.exit(main())
