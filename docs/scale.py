"""Measure what a study costs on the wire: discovery, idling, and a candidate, by the number of evaluators.

    .ci/in-env python docs/scale.py 4 8 16

Every evaluator is on a host of its own (a network namespace on a bridge), so that all traffic passes counted links.
Work is simulated, 1 s a candidate. Sizes are those of the paper's 6-joint arms and spec. Prints one table.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from hosts import Hosts, lacking
from nodes import Nodes, own_domain, told_so_far, wait_for

from mobo_core.bag.reader import read_bag

QUIET_S, IDLE_S, WORK_S = 8.0, 12.0, 20.0


def received(hosts: Hosts, count: int) -> list[int]:
    """Return the bytes that each host has received from the bridge so far."""
    command = ["cat", "/sys/class/net/eth0/statistics/rx_bytes"]
    found = []
    for host in range(count):
        # /sys shows the namespace it was mounted in.
        inside = [*hosts.on(host), "unshare", "--mount", "sh", "-c", f"mount -t sysfs none /sys && {' '.join(command)}"]
        found.append(int(subprocess.run(inside, check=True, capture_output=True, text=True).stdout))
    return found


def cpu_s(pid: int) -> float:
    """Return the CPU time, in s, that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(k: int) -> dict[str, float]:
    """Return the figures for ``k`` evaluators."""
    with own_domain() as environment, tempfile.TemporaryDirectory() as folder, Hosts(k + 1) as hosts:
        environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
        nodes, bag = Nodes(environment, Path(folder)), Path(folder) / "bag"
        try:
            evaluators = [
                nodes.start("evaluator", on=hosts.on(i + 1), engine="simulated", simulated_s=1.0, workers=1)
                for i in range(k)
            ]
            logs = sorted(Path(folder).glob("*_evaluator.log"))
            wait_for(lambda: all("ready" in log.read_text() for log in logs), "evaluators")
            time.sleep(QUIET_S)
            discovery = sum(received(hosts, k + 1))
            time.sleep(IDLE_S)
            idle = (sum(received(hosts, k + 1)) - discovery) / IDLE_S
            optimizer = nodes.optimizer(bag, n_trials=100_000, in_flight=2 * k, spec="paper", on=hosts.on(0))
            wait_for(lambda: told_so_far(bag) >= 2 * k, "trials")
            processes = [optimizer, *evaluators]
            before, cpu = received(hosts, k + 1), [cpu_s(p.pid) for p in processes]
            told, at = told_so_far(bag), time.time()
            time.sleep(WORK_S)
            after, cpu_after = received(hosts, k + 1), [cpu_s(p.pid) for p in processes]
            seconds, trials = time.time() - at, told_so_far(bag) - told
            sizes: dict[str, list[int]] = {}
            for content in read_bag(bag):
                for entry in content.entries:
                    sizes.setdefault(entry.kind, []).append(len(entry.data))
        finally:
            nodes.close()
    gone_in = [b - a for a, b in zip(before, after, strict=True)]
    used = [b - a for a, b in zip(cpu, cpu_after, strict=True)]
    return {
        "evaluators": k,
        "discovery, kB a pair": discovery / 1e3 / (k * (k - 1)),
        "idle, B/s a pair": idle / (k * (k - 1)),
        "trials/s": trials / seconds,
        "Candidate, B": mean(sizes["Candidate"]),
        "Evaluation, B": mean(sizes["Evaluation"]),
        "to an evaluator, B a trial": mean(gone_in[1:]) / trials,
        "to the optimizer, B a trial": gone_in[0] / trials,
        "optimizer, ms CPU a trial": 1e3 * used[0] / trials,
        "evaluator, ms CPU a trial of any": 1e3 * mean(used[1:]) / trials,
    }


def main() -> None:
    """Measure and print."""
    if lacking():
        sys.exit(lacking())
    rows = [measure(int(word)) for word in sys.argv[1:] or ("4", "8", "16")]
    for name in rows[0]:
        print(f"{name:34}", *(f"{row[name]:12.4g}" for row in rows))


if __name__ == "__main__":
    main()
