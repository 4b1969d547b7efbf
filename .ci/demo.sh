#!/usr/bin/env bash
# make demo: a study over ROS 2 with one optimizer and two evaluators, recorded, and a report of it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

number=1
while name=$(printf 'demo_%03d' "$number") && { [ -e "bags/$name" ] || [ -e "bags/${name}_report" ]; }; do
  number=$((number + 1))
done

.ci/in-env ros2 run mobo study --ros-args -p "n_trials:=${TRIALS:-300}" -p evaluators:=2 -p workers:=1 \
  -p "bag:=bags/$name" -p "study_name:=$name"
.ci/in-env mobo report "bags/$name" -o "bags/${name}_report"
