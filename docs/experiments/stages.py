"""Where the CPU time of a trial goes, stage by stage, in the optimizer and in a worker, at some numbers of trials.

    python docs/experiments/stages.py [--trials 2000,20000] [--more 200] [--spec mobo] [--sampler tpe] [--bag BAG]

Records a bag of TRIALS finished trials, their parameters drawn at random (or copies BAG, a recorded study), has the
real optimizer resume it, and answers MORE candidates with the kernel, all in one thread and without ROS, so that what
one stage leaves in the processor's caches meets the next one, as in a study. What nodes add, publishing, taking and the
pipes to workers, `feed.py` shows. Prints ms of CPU a trial, the mean over MORE trials, after as many to warm up.
"""

from __future__ import annotations

import argparse
import gc
import shutil
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))
from feed import Meter, record  # noqa: E402

OPTIMIZER = ("ask", "tell", "xacro", "decode", "encode", "bag", "judge, dispatch")
WORKER = ("take", "URDF check", "Pinocchio, chain", "kernel", "audit", "maps, objectives", "answer")


def stages() -> Meter:
    """Return a meter that divides time among the stages."""
    import mobo_core.bag.study_bag as study_bag
    import mobo_core.coordination.answer as answer
    import mobo_core.coordination.judge as judge
    import mobo_core.coordination.optimizer as core
    import mobo_core.evaluation.chain as chain
    import mobo_core.evaluation.evaluate as evaluation
    from mobo_core.bag.writer import McapFile
    from mobo_core.design.prepared import PreparedXacro
    from mobo_core.search.study import OrderedStudy

    meter = Meter((*OPTIMIZER, *WORKER, "other"))
    kernel_call = evaluation.kernel_call

    def timed_kernel(*args: Any) -> Any:
        before = meter.switch("kernel")
        compute, seconds = kernel_call(*args)
        meter.switch(before)

        def timed(*args: Any) -> None:
            before = meter.switch("kernel")
            compute(*args)
            meter.switch(before)

        return timed, seconds

    evaluation.kernel_call = timed_kernel
    for owner, name, stage in (
        (core.Optimizer, "on_evaluation", "judge, dispatch"),
        (core.Optimizer, "on_evaluator", "judge, dispatch"),
        (judge, "decode", "decode"),
        (study_bag, "encode", "encode"),
        (McapFile, "write", "bag"),
        (OrderedStudy, "ask", "ask"),
        (OrderedStudy, "tell", "tell"),
        (OrderedStudy, "_catch_up", "tell"),
        (PreparedXacro, "to_urdf", "xacro"),
        (answer.Answering, "answer", "answer"),
        (evaluation, "evaluate", "maps, objectives"),
        (evaluation, "asked_chain", "Pinocchio, chain"),
        (chain, "check_urdf", "URDF check"),
        (evaluation.Audit, "add", "audit"),
        (evaluation.Audit, "result", "audit"),
    ):
        meter.wrap(owner, name, stage)
    return meter


def measure(folder: Path, more: int, meter: Meter) -> dict[str, float]:
    """Return ms of CPU a trial by stage, of ``more`` trials that follow those of a bag."""
    from mobo_core.bag.study_bag import StudyBag, recorded_study
    from mobo_core.coordination.answer import Answering
    from mobo_core.coordination.dispatch import Dispatcher
    from mobo_core.coordination.optimizer import Optimizer
    from mobo_core.messages import Candidate, EvaluatorStatus, decode, encode

    found = recorded_study(folder)
    assert found is not None
    name, settings = found
    bag, published = StudyBag(folder, name, settings, resume=True), []
    optimizer = Optimizer(
        bag, settings, sys.maxsize, Dispatcher(), lambda topic, data: published.append((topic, data)),
        lambda line: None, lambda line: None,
    )  # fmt: skip
    answering = Answering("here")
    answering.load()
    heartbeat = encode(EvaluatorStatus(evaluator="here", state=EvaluatorStatus.ALIVE, workers=settings.in_flight))
    # A worker has none of the optimizer's many objects for the garbage collector to look through.
    gc.collect()
    gc.freeze()
    for last in (len(optimizer.study.told) + more, len(optimizer.study.told) + 2 * more):
        meter.switch("other")
        meter.spent = dict.fromkeys(meter.spent, 0.0)
        while len(optimizer.study.told) < last:
            if not published:
                optimizer.on_evaluator(heartbeat, time.monotonic())
                continue
            topic, data = published.pop(0)
            if topic == "candidates":
                before = meter.switch("take")
                candidate = decode(Candidate, data)
                meter.switch(before)
                evaluation = answering.answer(candidate)
                before = meter.switch("answer")
                data = encode(evaluation)
                meter.switch(before)
                optimizer.on_evaluation(data, time.monotonic())
    meter.switch("other")
    bag.close()
    gc.unfreeze()
    return {stage: seconds / more * 1e3 for stage, seconds in meter.spent.items()}


def main() -> int:
    """Record, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", default="2000,20000")
    parser.add_argument("--more", type=int, default=200)
    parser.add_argument("--spec", default="mobo")
    parser.add_argument("--sampler", default="tpe")
    parser.add_argument("--bag", type=Path)
    args = parser.parse_args()
    from mobo_core.evaluation import load_spec
    from mobo_core.search.study import StudySettings

    meter = stages()
    for size in [""] if args.bag else args.trials.split(","):
        with tempfile.TemporaryDirectory() as temporary:
            folder = Path(temporary) / (args.bag.resolve().name if args.bag else "bag")
            if args.bag:
                shutil.copytree(args.bag, folder)
            else:
                settings = StudySettings(spec=load_spec(args.spec), sampler=args.sampler)
                record(folder, int(size), settings)
            spent = measure(folder, args.more, meter)
        kernel = spent["kernel"]
        total = sum(spent.values()) - spent["other"]
        print(f"after {size or 'the'} trials{f' of {args.bag}' if args.bag else ''}, ms of CPU a trial")
        for title, names in (("optimizer", OPTIMIZER), ("worker", WORKER)):
            whole = sum(spent[name] for name in names)
            print(f"\n| {title} | " + " | ".join(names) + " | sum |\n|" + " --- |" * (len(names) + 2))
            print("| | " + " | ".join(f"{spent[name]:.2f}" for name in names) + f" | {whole:.2f} |")
        print(f"\nall but the kernel: {total - kernel:.2f}\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
