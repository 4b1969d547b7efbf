"""The study node: an optimizer and evaluators on this host, started, watched, and ended together."""

from __future__ import annotations

import signal
import sys
import time

from rclpy.executors import Executor
from rclpy.node import Node

from mobo.child import Child
from mobo.parameters import declare
from mobo.progress import StudyProgress
from mobo.runtime import STATUS_QOS, run, subscribe
from mobo_core import messages
from mobo_core.arms.baselines import checked_plan
from mobo_core.bag.study_bag import check_writable
from mobo_core.coordination.arguments import parameter_word
from mobo_core.coordination.closing import closing_line, go_on_command, is_last
from mobo_core.coordination.options import EvaluatorOptions, OptimizerOptions, StudyOptions
from mobo_core.coordination.parameters import help_text
from mobo_core.coordination.plan import StudyPlan
from mobo_core.coordination.stop import Stop
from mobo_core.coordination.supervision import Restarts
from mobo_core.errors import InputError
from mobo_core.messages import decode
from mobo_core.settings import Settings
from mobo_msgs.msg import StudyStatus

HELP = help_text(
    "study",
    "Run a whole study on this host: one optimizer, some evaluators, a progress bar. More evaluators may join.",
    StudyOptions,
    ["--ros-args -p study_name:=first -p n_trials:=300", "--ros-args -p n_joints:=7 -p evaluators:=1 -p workers:=8"],
)

_PATIENCE_S = 10.0
_LAST_WORD_S = 3.0  # an optimizer that ends waits until its last word has come in here


def _arguments(node: Node, options: StudyOptions, of: type[Settings], *more: str) -> list[str]:
    """Return the command line that hands on the options which were set here, and those that ``more`` names."""
    # The progress bar tells what the nodes would; warnings come through.
    arguments = ["-r", f"__ns:={node.get_namespace()}", "--log-level", "warn"]
    for name in sorted(of.model_fields.keys() & {*options.model_fields_set, *more}):
        arguments += ["-p", parameter_word(name, getattr(options, name))]
    return arguments


class _Supervisor:
    def __init__(self, node: Node, options: StudyOptions, plan: StudyPlan) -> None:
        self._progress = StudyProgress(plan.name, options.n_trials)
        if notice := plan.notice(options):
            self._progress.say(notice)
        self._folder, self._go_on = plan.folder, go_on_command(options, plan.name, node.get_namespace())
        self._restarts = Restarts()
        if engine := plan.settings.engine:  # named or not: optimizer and evaluators shall have the same
            options = options.model_copy(update={"engine": engine})
        asked = _arguments(node, options, OptimizerOptions)
        self.optimizer = Child("optimizer", asked, signal.SIGTERM)
        # It refuses bad parameters or a bag in use before there is anything to evaluate.
        self.evaluators: list[Child] = []
        answered = _arguments(node, options, EvaluatorOptions, "workers")
        for _ in range(options.evaluators):
            self.evaluators.append(Child("evaluator", answered, signal.SIGKILL))
        self._study = plan.name
        self.status: messages.StudyStatus | None = None
        subscribe(node, StudyStatus, "study", self._on_status, STATUS_QOS)

    def _on_status(self, data: bytes) -> None:
        try:
            status = decode(messages.StudyStatus, data)
        except InputError:
            return
        if status.study == self._study:
            self.status = status
            self._progress.show(status)

    def step(self) -> int | None:
        """Restart what died; return the exit code when the optimizer has ended for good."""
        now, code = time.monotonic(), self.optimizer.process.poll()
        told = -1 if self.status is None else int(self.status.told)
        if code is not None:
            if code >= 0:
                return code
            if not self._restarts.died("optimizer", told, now):
                self._progress.say("the optimizer keeps dying")
                return 1
            self._progress.say(f"optimizer died of signal {-code}; resuming")
            self.optimizer.start(["-p", "resume:=true"])
        for number, child in enumerate(self.evaluators):
            name = f"evaluator {number}"
            if child.process.poll() is None:
                continue
            if not self._restarts.is_dead(name):
                if not self._restarts.died(name, told, now):
                    self._progress.say("an evaluator keeps dying")
                    return 1
                self._progress.say(f"an evaluator ended with {child.process.returncode}; starting another")
            elif self._restarts.is_due(name, now):
                self._restarts.started(name)
                child.start()
        return None

    def close(self, executor: Executor) -> None:
        """End the optimizer, which finishes its bag, then the evaluators; leave none behind, but a line."""
        until = time.monotonic() + _PATIENCE_S
        self.optimizer.stop()
        while self.optimizer.process.poll() is None and time.monotonic() < until:
            executor.spin_once(timeout_sec=0.05)
        self.optimizer.wait(until)
        heard = time.monotonic() + _LAST_WORD_S
        while self.optimizer.process.returncode in (0, 1) and not is_last(self.status) and time.monotonic() < heard:
            executor.spin_once(timeout_sec=0.05)
        for child in self.evaluators:
            child.stop()
        for child in self.evaluators:
            child.wait(until)
        self._progress.close()
        if self.optimizer.process.returncode != 2:  # which it explains itself
            self._progress.say(closing_line(self.status, self._folder, self._go_on))


def _body(node: Node, executor: Executor, stop: Stop) -> int:
    options = declare(node, StudyOptions)
    options.check_load(options.evaluators)
    plan = checked_plan(options)
    check_writable(plan.folder)
    if stop:
        return 1
    supervisor = _Supervisor(node, options, plan)
    code: int | None = None
    try:
        while not stop and code is None:
            executor.spin_once(timeout_sec=0.1)
            code = supervisor.step()
    finally:
        supervisor.close(executor)
    code = supervisor.optimizer.process.returncode if code is None else code
    return code if code in (0, 2) else 1


def main() -> int:
    """Run the node; return its exit code."""
    return run("study", HELP, StudyOptions, _body)


if __name__ == "__main__":
    sys.exit(main())
