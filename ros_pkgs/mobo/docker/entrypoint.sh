#!/bin/bash
# Runs a command with ROS 2 and mobo sourced, as itself, so that signals reach it.
set -e
source /opt/ros/jazzy/setup.bash
source /mobo/.venv/bin/activate
source /mobo/install/setup.bash
exec "$@"
