"""How many candidates a second one optimizer feeds to 64 evaluator slots, and what a trial costs it.

    python docs/experiments/feed.py [--trials 20000] [--more 1500] [--sampler tpe] [--in-flight 128]

Records a bag of TRIALS finished trials (parameters drawn at random, values of the simulated engine), then starts
the real optimizer with resume:=true and 8 real evaluators of 8 workers each, simulated_s:=0.0, on this host, and
has them finish MORE trials. The rate is taken between the trials that come 256 after the first and 128 before the
last. The table gives CPU time of the optimizer's one thread by what it is spent on; the figures below it are of the
whole processes, the middleware's threads included. Run it in a shell as for `ros2 run`.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

PARTS = ("ask", "xacro", "publish", "receive", "record", "tell", "other")
REPORT = "MOBO_FEED_REPORT"


# ---- in the optimizer's process


class Meter:
    """Divides one thread's CPU time among parts; of nested calls the innermost counts."""

    def __init__(self, parts: tuple[str, ...] = PARTS) -> None:
        self.spent = dict.fromkeys(parts, 0.0)
        self._part, self._since = "other", time.thread_time()

    def switch(self, part: str) -> str:
        """Count what follows towards ``part``; return what was counted before."""
        now, before = time.thread_time(), self._part
        self.spent[before] += now - self._since
        self._part, self._since = part, now
        return before

    def wrap(self, owner: Any, name: str, part: str) -> None:
        """Count the time in a function towards ``part``."""
        inner = getattr(owner, name)

        def timed(*args: Any, **kwargs: Any) -> Any:
            before = self.switch(part)
            try:
                return inner(*args, **kwargs)
            finally:
                self.switch(before)

        setattr(owner, name, timed)


def resident_kb() -> int:
    """Return this process's resident memory in kB."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


def cpu_s() -> float:
    """Return the CPU seconds of all threads of this process."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


def optimizer(first: int, last: int) -> int:
    """Run the optimizer node; write what it cost between the telling of two trials into a file."""
    import rclpy.publisher
    from rclpy.executors import SingleThreadedExecutor

    import mobo.optimizer
    import mobo_core.coordination.judge as judge
    import mobo_core.coordination.optimizer as core
    from mobo_core.bag.study_bag import StudyBag
    from mobo_core.design.prepared import PreparedXacro
    from mobo_core.search.study import OrderedStudy

    meter = Meter()
    for owner, name, part in (
        (SingleThreadedExecutor, "spin_once", "receive"),
        (core.Optimizer, "on_evaluator", "other"),
        (core.Optimizer, "on_evaluation", "other"),
        (core.Optimizer, "tick", "other"),
        (core.Optimizer, "status", "other"),
        (judge, "decode", "receive"),
        (OrderedStudy, "ask", "ask"),
        (OrderedStudy, "_catch_up", "tell"),
        (OrderedStudy, "tell", "tell"),
        (PreparedXacro, "to_urdf", "xacro"),
        (rclpy.publisher.Publisher, "publish", "publish"),
        (StudyBag, "append", "record"),
        (StudyBag, "append_raw", "record"),
    ):
        meter.wrap(owner, name, part)
    tell, report = OrderedStudy.tell, Path(os.environ[REPORT])
    init, replay, check = core.Optimizer.__init__, core.Optimizer._replay, StudyBag.__init__
    running: list[Any] = []
    read = 0.0

    def told(self: Any, told: Any) -> None:
        tell(self, told)
        if told.number in (first, last):
            meter.switch(meter.switch("other"))
            mark = {"wall": time.perf_counter(), "cpu": cpu_s(), "kb": resident_kb(), **meter.spent}
            mark |= {"resent": running[0].resent, "unused": running[0].status(0).answers_unused}
            report.with_suffix(f".{told.number}").write_text(json.dumps(mark))

    def opened(self: Any, *args: Any, **kwargs: Any) -> None:
        nonlocal read
        before = time.perf_counter()
        check(self, *args, **kwargs)
        read = time.perf_counter() - before

    def begun(self: Any, *args: Any, **kwargs: Any) -> None:
        running.append(self)
        init(self, *args, **kwargs)

    def replayed(self: Any, past: Any) -> None:
        before = time.perf_counter()
        replay(self, past)
        rebuilt = time.perf_counter() - before
        report.with_suffix(".resume").write_text(json.dumps({"read": read, "rebuilt": rebuilt, "kb": resident_kb()}))

    for owner, name, function in (
        (OrderedStudy, "tell", told),
        (StudyBag, "__init__", opened),
        (core.Optimizer, "__init__", begun),
        (core.Optimizer, "_replay", replayed),
    ):
        setattr(owner, name, function)
    return mobo.optimizer.main()


# ---- around it


def record(folder: Path, trials: int, settings: Any) -> None:
    """Record a bag of ``trials`` finished trials, their parameters drawn at random."""
    from optuna.distributions import CategoricalDistribution

    from mobo_core.bag.study_bag import StudyBag
    from mobo_core.coordination.answer import Answering
    from mobo_core.design.description import TIP_LINK
    from mobo_core.design.prepared import PreparedXacro
    from mobo_core.evaluation.spec_message import spec_to_message
    from mobo_core.messages import Candidate, Trial

    space, draw = settings.space, random.Random(0)
    xacro, answering = PreparedXacro(space), Answering("earlier", "simulated", simulated_s=0.0)
    spec, bag = spec_to_message(settings.spec), StudyBag(folder, "feed", settings, resume=False)
    names = {f"J{i + 1}": tuple(space.joint_types) for i in range(space.n_joints)}
    some = {name: choices[0] for name, choices in names.items()}
    some |= {f"u{i + 1}": 0.5 for i in range(space.n_joints - 1)}
    distributions = space.distributions(some)
    for trial in range(trials):
        params = {
            name: draw.choice(d.choices) if isinstance(d, CategoricalDistribution) else draw.random()
            for name, d in distributions.items()
        }
        design, who = space.design(params), {"study": "feed", "trial": trial, "attempt": 1, "evaluator": "earlier"}
        candidate = Candidate(**who, sampled_joints=design.sampled_joints, joints=design.joints, lengths=design.lengths,
            urdf=xacro.to_urdf(design), tip=TIP_LINK, spec=spec, params_json=json.dumps(params),
        )  # fmt: skip
        evaluation = answering.answer(candidate)
        bag.append("candidates", candidate)
        bag.append("evaluations", evaluation)
        bag.append("trials", Trial(**who, reach=evaluation.reach, torque=evaluation.torque))
    bag.close()


def plain_xacro_ms(settings: Any, n: int = 50) -> float:
    """Return the CPU time that xacro takes for one arm if it expands all of it, in ms."""
    import optuna
    from optuna.samplers import RandomSampler

    from mobo_core.design import to_urdf

    study = optuna.create_study(sampler=RandomSampler(seed=0))
    designs = [settings.space.suggest(study.ask()) for _ in range(n)]
    began = time.thread_time()
    for design in designs:
        to_urdf(design, settings.space)
    return (time.thread_time() - began) / n * 1e3


def processes_below(pid: int) -> Iterator[int]:
    """Yield a process and all its descendants."""
    yield pid
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            yield from processes_below(int(child))


def cpu_of(pids: list[int]) -> float:
    """Return the CPU seconds that processes have used."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def busy_s() -> float:
    """Return the CPU seconds that this machine has spent since it started, idle ones left out."""
    fields = [int(field) for field in Path("/proc/stat").read_text().split("\n", 1)[0].split()[1:]]
    return (sum(fields[:8]) - fields[3] - fields[4]) / os.sysconf("SC_CLK_TCK")


def wait_for(path: Path, process: subprocess.Popen[Any]) -> dict[str, Any]:
    """Return what the optimizer writes into ``path``."""
    while not path.exists():
        if process.poll() not in (None, 0):
            raise SystemExit(f"the optimizer ended with code {process.returncode}")
        time.sleep(0.02)
    while not (text := path.read_text()):
        time.sleep(0.001)
    found: dict[str, Any] = json.loads(text)
    return found


def main() -> int:
    """Record, run, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=20_000)
    parser.add_argument("--more", type=int, default=1500)
    parser.add_argument("--sampler", default="tpe")
    parser.add_argument("--in-flight", type=int, default=128)
    parser.add_argument("--evaluators", type=int, default=8)
    parser.add_argument("--workers", type=int, default=8)
    args = parser.parse_args()
    from mobo_core.search.study import StudySettings

    settings = StudySettings.of({"sampler": args.sampler, "in_flight": args.in_flight})
    os.environ.setdefault("ROS_DOMAIN_ID", "77")
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        began = time.perf_counter()
        record(folder / "bag", args.trials, settings)
        size = sum(file.stat().st_size for file in (folder / "bag").glob("*.mcap"))
        took = time.perf_counter() - began
        print(f"recorded {args.trials} trials in {took:.0f} s, {size / args.trials:.0f} bytes each")
        print(f"plain xacro: {plain_xacro_ms(settings):.1f} ms of CPU an arm", flush=True)
        return run(args, folder)


def run(args: argparse.Namespace, folder: Path) -> int:
    """Start the nodes, wait for the marks, print the table."""
    first, last = args.trials + 256, args.trials + args.more - 128
    report, started = folder / "report", []
    evaluator = ["-m", "mobo.evaluator", "--ros-args", "--log-level", "warn", "-p", "engine:=simulated"]
    evaluator += ["-p", "simulated_s:=0.0", "-p", f"workers:={args.workers}"]
    command = [__file__, "--as-optimizer", str(first), str(last), "--ros-args", "--log-level", "warn"]
    command += ["-p", "study_name:=feed", "-p", f"bag:={folder / 'bag'}", "-p", "resume:=true"]
    command += ["-p", f"n_trials:={args.trials + args.more}", "-p", f"in_flight:={args.in_flight}"]
    command += ["-p", f"sampler:={args.sampler}"]

    def start(rest: list[str]) -> subprocess.Popen[Any]:
        return subprocess.Popen([sys.executable, *rest], env={**os.environ, REPORT: str(report)})

    try:
        started = [start(evaluator) for _ in range(args.evaluators)]
        node = start(command)
        started.append(node)
        resumed = wait_for(report.with_suffix(".resume"), node)
        print(f"resumed: bag read in {resumed['read']:.1f} s, study rebuilt in {resumed['rebuilt']:.1f} s", end="")
        print(f", {resumed['kb'] / 1024:.0f} MB", flush=True)
        a = wait_for(report.with_suffix(f".{first}"), node)
        pids = [pid for process in started[:-1] for pid in processes_below(process.pid)]
        nodes = [process.pid for process in started[:-1]]
        before, before_nodes, before_busy = cpu_of(pids), cpu_of(nodes), busy_s()
        b = wait_for(report.with_suffix(f".{last}"), node)
        busy, all_ms = busy_s() - before_busy, (cpu_of(pids) - before) / (last - first) * 1e3
        nodes_ms = (cpu_of(nodes) - before_nodes) / (last - first) * 1e3
        n, wall = last - first, b["wall"] - a["wall"]
        print(f"{n / wall:.0f} candidates/s over {n} trials, sampler {args.sampler}, in_flight {args.in_flight}")
        print("| " + " | ".join(PARTS) + " | sum |\n|" + " --- |" * (len(PARTS) + 1))
        each = [(b[part] - a[part]) / n * 1e3 for part in PARTS]
        print("| " + " | ".join(f"{ms:.2f}" for ms in [*each, sum(each)]) + " |")
        cpu = (b["cpu"] - a["cpu"]) / n * 1e3
        print(f"optimizer's process: {cpu:.2f} ms of CPU a trial, {wall / n * 1e3:.2f} ms of wall time")
        print(f"evaluators: {nodes_ms:.2f} ms of CPU a trial, their workers {all_ms - nodes_ms:.2f}")
        others = busy - (b["cpu"] - a["cpu"]) - all_ms * n / 1e3
        print(f"all else on this machine kept {others / wall:.2f} of its {os.cpu_count()} cores busy meanwhile")
        print(f"optimizer's memory: {b['kb'] / 1024:.0f} MB, grown by {(b['kb'] - a['kb']) / n:.1f} kB a trial")
        print(f"candidates sent again: {b['resent'] - a['resent']}, answers of no use: {b['unused'] - a['unused']}")
        return node.wait()
    finally:
        for process in started:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in started:
            process.wait(30)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--as-optimizer"]:
        numbers = int(sys.argv[2]), int(sys.argv[3])
        sys.argv[1:4] = []
        sys.exit(optimizer(*numbers))
    sys.exit(main())
