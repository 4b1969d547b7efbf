"""Measure what a study costs on the wire: discovery, idling, and a candidate, by the number of evaluators.

    .ci/in-env python docs/experiments/scale.py 4 8 16
    .ci/in-env python docs/experiments/scale.py --broadcast 1 16 64   # cost of publishing, by number of readers

Every evaluator is on a host of its own (a network namespace on a bridge), so that all traffic passes counted links.
Work is simulated, 1 s a candidate. Sizes are those of the paper's 6-joint arms and spec. Prints one table.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

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


def resident_bytes(pid: int) -> int:
    """Return the memory that a process holds."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


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
            started = [cpu_s(process.pid) for process in evaluators]
            memory = [resident_bytes(process.pid) for process in evaluators]
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
        "evaluator, s CPU to start": mean(started),
        "evaluator, MB": mean(memory) / 1e6,
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


_READERS = """
import sys, time, rclpy
from mobo.runtime import CANDIDATES_QOS
from mobo_msgs.msg import Candidate
kept = []
for i in range(int(sys.argv[1])):
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node(f"reader{i}", context=context, start_parameter_services=False)
    kept.append((node, node.create_subscription(Candidate, "candidates", print, CANDIDATES_QOS)))
time.sleep(1000)
"""


def broadcast(readers: int, count: int = 200, size: int = 8475) -> dict[str, float]:
    """Return the CPU that it takes to publish a candidate to so many readers, each a DDS participant, on this host."""
    with own_domain() as environment:
        environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "SUBNET"
        os.environ.update(environment)
        import rclpy

        from mobo.runtime import CANDIDATES_QOS
        from mobo_msgs.msg import Candidate

        child = subprocess.Popen([sys.executable, "-c", _READERS, str(readers)], env=environment)
        context = rclpy.Context()
        rclpy.init(context=context)
        node = rclpy.create_node("writer", context=context)
        try:
            publisher = node.create_publisher(Candidate, "candidates", CANDIDATES_QOS)
            wait_for(lambda: publisher.get_subscription_count() == readers, "readers", 120)
            time.sleep(QUIET_S)
            message = Candidate(urdf="x" * (size - 600))
            cpu = time.process_time()
            for _ in range(count):
                publisher.publish(message)
                time.sleep(0.01)
            used = time.process_time() - cpu
        finally:
            child.kill()
            child.wait()
            node.destroy_node()
            rclpy.shutdown(context=context)
    return {"readers": readers, "writer, ms CPU a candidate": 1e3 * used / count}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("counts", type=int, nargs="+", metavar="N", help="evaluators, or readers")
    parser.add_argument("--broadcast", action="store_true", help="what publishing costs instead, on this host alone")
    args = parser.parse_args()
    if not args.broadcast and lacking():
        sys.exit(lacking())
    rows = [(broadcast if args.broadcast else measure)(count) for count in args.counts]
    for name in rows[0]:
        print(f"{name:34}", *(f"{row[name]:12.4g}" for row in rows))


if __name__ == "__main__":
    main()
