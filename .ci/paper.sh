#!/usr/bin/env bash
# make paper: the studies of docs/paper.md over ROS 2, one after the other; a second call skips what is done and goes on
# with what stopped. Each leaves its bag and its report in bags/paper/; what docs/paper/ lacks yet goes there: a table of all
# trials, the report's pictures, of tpe6 and tpe7 a bag of their best arms.
# PAPER: the studies to run, by name (all). PAPER_BAGS: where their bags are. PAPER_TRIALS: so many trials instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bags=${PAPER_BAGS:-bags/paper}
wide=docs/paper/wide.yaml

# name trials what differs
studies=(
  "paper6 20000 n_joints:=6 spec:=paper sampler:=paper"
  "paper7 20000 n_joints:=7 spec:=paper sampler:=paper"
  "tpe6 20000 n_joints:=6 spec:=paper sampler:=tpe"
  "tpe7 20000 n_joints:=7 spec:=paper sampler:=tpe"
  "wide6 20000 n_joints:=6 spec:=paper sampler:=tpe space:=$wide"
  "wide7 20000 n_joints:=7 spec:=paper sampler:=tpe space:=$wide"
  "complete6 20000 n_joints:=6 spec:=mobo sampler:=tpe"
  "tpe6_seed1 20000 n_joints:=6 spec:=paper sampler:=tpe seed:=1"
  "tpe6_seed2 20000 n_joints:=6 spec:=paper sampler:=tpe seed:=2"
  "structured7 60000 n_joints:=7 spec:=mobo sampler:=structured"
)

study() { # name trials settings…
  local settings=()
  for setting in "${@:3}"; do settings+=(-p "$setting"); done
  echo "== $1: ${*:3}, $2 trials"
  .ci/in-env ros2 run mobo study --ros-args -r "__ns:=/$1" -p "study_name:=$1" -p "bag:=$bags/$1" -p resume:=true \
    -p "n_trials:=$2" -p evaluators:=1 -p workers:=2 "${settings[@]}"
}

# A bag of the arms that count, small enough to be kept: the front, and the best of each order.
best() { # name settings…
  local name=${1}_best table=$bags/${1}_best.csv
  if [ -e "docs/paper/$name" ]; then return; fi
  .ci/in-env mobo export table "$bags/$1" --best -o "$table"
  study "$name" "$(($(wc -l <"$table") - 1))" "${@:2}" "baselines:=$table"
  mkdir -p "docs/paper/$name"
  cp "$bags/$name"/{metadata.yaml,*.mcap} "docs/paper/$name"
}

run() { # name trials settings…
  local name=$1 trials=${PAPER_TRIALS:-$2} bag=$bags/$1
  study "$name" "$trials" "${@:3}"
  .ci/in-env mobo report "$bag" -o "$bags/${name}_report" >"$bags/$name.txt"
  echo "report: $bags/${name}_report/index.html"
  if [ -n "${PAPER_TRIALS:-}" ] || [ -e "docs/paper/$name.parquet" ]; then return; fi # a checkout has its results
  .ci/in-env mobo export table "$bag" -o "docs/paper/$name.parquet"
  for picture in sampling structures lengths claims; do
    cp "$bags/${name}_report/$picture.png" "docs/paper/${name}_$picture.png"
  done
  if [[ $name == tpe[67] ]]; then best "$name" "${@:3}"; fi
}

mkdir -p "$bags"
for study in "${studies[@]}"; do
  read -ra row <<<"$study"
  if [ -z "${PAPER:-}" ] || [[ " $PAPER " == *" ${row[0]} "* ]]; then run "${row[@]}"; fi
done
