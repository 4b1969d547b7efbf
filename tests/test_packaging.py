"""What is shipped: wheel, source distribution, ROS packages and set-up, checked on this tree."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

import mobo_core

ROOT = Path(__file__).parent.parent
MESSAGES = sorted(path.name for path in (ROOT / "ros_pkgs/mobo_msgs/msg").glob("*.msg"))


def run(*command: str | Path, cwd: Path = ROOT, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, **environment},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
    )


def hatch(target: str, source: Path, into: Path) -> Path:
    built = run(sys.executable, "-m", "hatchling", "build", "-t", target, "-d", into, cwd=source)
    assert built.returncode == 0, built.stderr
    return next(into.iterdir())


def contents(wheel: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return contents(hatch("wheel", ROOT, tmp_path_factory.mktemp("wheel")))


def test_wheel_carries_macros_and_messages(wheel: dict[str, bytes]) -> None:
    for folder, packaged in (("xacro", "mobo_core/xacro"), ("ros_pkgs/mobo_msgs/msg", "mobo_core/msg")):
        files = {path.name: path.read_bytes() for path in (ROOT / folder).iterdir() if path.is_file()}
        assert files
        assert {name: wheel.get(f"{packaged}/{name}") for name in files} == files
    assert "mobo_core/xacro/roll.xacro" in wheel
    assert "mobo_core/msg/Candidate.msg" in wheel
    assert "mobo_core/py.typed" in wheel


def test_wheel_holds_one_package_and_no_second_xacro(wheel: dict[str, bytes]) -> None:
    assert {name.split("/")[0] for name in wheel} == {"mobo_core", "mobo_core-0.1.0.dist-info"}
    assert not (ROOT / "xacro/__init__.py").exists()


def test_source_distribution_builds_the_same_wheel(wheel: dict[str, bytes], tmp_path: Path) -> None:
    with tarfile.open(hatch("sdist", ROOT, tmp_path / "sdist")) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    assert contents(hatch("wheel", source, tmp_path / "wheel")) == wheel


def test_all_versions_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = {"pyproject.toml": project["version"]}
    for package in ("mobo", "mobo_msgs"):
        manifest = ElementTree.parse(ROOT / "ros_pkgs" / package / "package.xml")
        found[f"{package}/package.xml"] = manifest.findtext("version") or ""
    for name in ("ros_pkgs/mobo/setup.py", "ros_pkgs/ros2_standin/pyproject.toml", "CITATION.cff"):
        match = re.search(r'^\s*version *[=:] *"?([\d.]+)', (ROOT / name).read_text(), re.MULTILINE)
        found[name] = match.group(1) if match else ""
    assert found == dict.fromkeys(found, mobo_core.__version__)


def test_every_dependency_is_pinned() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = project["dependencies"] + project["optional-dependencies"]["dev"]
    for file in (ROOT / ".ci").glob("requirements-*.txt"):
        wanted += [line for line in file.read_text().splitlines() if line and not line.startswith("#")]
    pinned = re.findall(r"^([\w.-]+)==", (ROOT / ".ci/constraints.txt").read_text(), re.MULTILINE)
    names = {re.split(r"[<>=!~ \[]", entry)[0].lower() for entry in wanted}
    assert names <= {name.lower() for name in pinned}


def test_every_message_is_built() -> None:
    listed = re.findall(r'"msg/(\w+\.msg)"', (ROOT / "ros_pkgs/mobo_msgs/CMakeLists.txt").read_text())
    assert sorted(listed) == MESSAGES


def test_nodes_package_installs_what_there_is() -> None:
    """Every folder that setup.py names is there, and every node's module; nothing of launch/ is left out."""
    package = ROOT / "ros_pkgs/mobo"
    spied = (
        "import json, runpy, setuptools\n"
        "setuptools.setup = lambda **given: print(json.dumps([given['data_files'], given['entry_points']]))\n"
        "runpy.run_path('setup.py')"
    )
    files, entries = json.loads(run(sys.executable, "-c", spied, cwd=package).stdout)
    assert all(listed and all((package / file).is_file() for file in listed) for _, listed in files)
    assert {str(path.relative_to(package)) for path in (package / "launch").glob("*.py")} <= {
        file for _, listed in files for file in listed
    }
    for entry in entries["console_scripts"]:
        module = entry.split("=")[1].split(":")[0].strip()
        assert (package / f"{module.replace('.', '/')}.py").is_file()


def test_colcon_takes_the_packages_as_ros_packages() -> None:
    pytest.importorskip("colcon_ros")
    colcon = "import sys; from colcon_core.command import main; sys.exit(main())"
    listed = run(sys.executable, "-c", colcon, "list", "--base-paths", "ros_pkgs")
    assert listed.stdout.splitlines() == [
        "mobo\tros_pkgs/mobo\t(ros.ament_python)",
        "mobo_msgs\tros_pkgs/mobo_msgs\t(ros.ament_cmake)",
    ]


def test_no_tracked_file_names_a_registry_or_a_home_folder() -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("not a checkout")
    hosts = r"pypi\.org|python" + r"hosted|deb\.debian|npmjs\."
    private = re.compile(rf"{hosts}|(?<![\w.])/(?:home|root|work|Users)/".encode())
    tracked = run("git", "ls-files", "-z").stdout.split("\0")
    files = [ROOT / name for name in tracked if name and (ROOT / name).is_file()]
    named = {
        f"{path.relative_to(ROOT)}: {match.group().decode()}"
        for path in files
        if b"\0" not in (text := path.read_bytes())
        for match in private.finditer(text)
    }
    assert files
    assert not named


def setup(**environment: str) -> subprocess.CompletedProcess[str]:
    """Run the set-up where it must refuse before it does anything."""
    bash = shutil.which("bash")
    assert bash
    return run(bash, ROOT / ".ci/setup.sh", **environment)


def test_setup_names_the_debian_package_of_each_missing_tool(tmp_path: Path) -> None:
    dirname = shutil.which("dirname")
    assert dirname
    (tmp_path / "dirname").symlink_to(dirname)
    refused = setup(PATH=str(tmp_path), PYTHON="python3")
    assert refused.returncode == 2
    assert [line.split()[-1] for line in refused.stderr.splitlines()] == [
        *("git", "gcc", "g++", "cmake", "make", "python3")
    ]


def test_setup_names_the_parts_that_python_lacks(tmp_path: Path) -> None:
    bare = tmp_path / "python3.12"
    bare.write_text('#!/bin/sh\ncase "$2" in *version_info*) echo 3.12 ;; *) exit 1 ;; esac\n')
    bare.chmod(0o755)
    refused = setup(PYTHON=str(bare))
    assert refused.returncode == 2
    assert [line.split()[-1] for line in refused.stderr.splitlines()] == ["python3.12-venv", "python3.12-dev"]


def test_setup_refuses_another_python_version(tmp_path: Path) -> None:
    other = tmp_path / "python3.13"
    other.write_text("#!/bin/sh\necho 3.13\n")
    other.chmod(0o755)
    refused = setup(PYTHON=str(other))
    assert refused.returncode == 2
    assert refused.stderr.count("\n") == 1
    assert "3.13, expected 3.11 or 3.12" in refused.stderr
