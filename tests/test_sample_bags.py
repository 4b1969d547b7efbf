"""Studies recorded with older trees stay true: they verify, are reported, and go on."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from nodes import values
from rosbags.highlevel import AnyReader
from studies import mobo, run_study

from mobo_core.bag.collector import read_study

ROOT = Path(__file__).parents[1]
SAMPLES = sorted(path for path in (ROOT / "bags" / "sample").iterdir() if path.is_dir())

pytestmark = pytest.mark.skipif(not SAMPLES, reason="no checkout")


def test_the_samples_are_there() -> None:
    """Two studies, with a failed trial and an enqueued one among them, in less than 400 kB."""
    studies = [read_study(bag) for bag in SAMPLES]
    assert [(study.name, len(study.trials)) for study in studies] == [("mobo_7", 30), ("paper_6", 60)]
    assert [trial.trial for trial in studies[1].trials.values() if trial.reason] == [30]
    assert [command.command for command in studies[1].commands] == ["enqueue"]
    assert all(study.record["schema_version"] == "1" for study in studies)
    assert sum(file.stat().st_size for bag in SAMPLES for file in bag.iterdir()) < 400_000


@pytest.mark.parametrize("bag", SAMPLES, ids=lambda bag: bag.name)
def test_a_sample_verifies_and_is_reported(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every URDF, design, evaluation and told value of it is what this tree makes of it; the report has its page."""
    assert mobo("verify", bag, "--workers", 1) == 0
    assert capsys.readouterr().out.startswith("good: ")
    assert mobo("report", bag, "-o", tmp_path) == 0
    assert (tmp_path / "index.html").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.parametrize("bag", SAMPLES, ids=lambda bag: bag.name)
def test_a_sample_goes_on(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Resumed in a copy it keeps its trials, verifies, and is still read by rosbags, compacted too."""
    copy = tmp_path / bag.name
    shutil.copytree(bag, copy)
    before, study = values(bag), read_study(bag)
    settings = study.settings.to_dict()
    run_study(copy, len(before) + 4, name=study.name, settings=settings, engine="kernel", resume=True, statuses=True)
    assert values(copy)[: len(before)] == before
    for _ in range(2):
        assert mobo("verify", copy, "--sample", 12, "--workers", 1) == 0, capsys.readouterr()  # all of it: above
        with AnyReader([copy]) as reader:
            topics = [connection.topic for connection, _, data in reader.messages() if reader.deserialize(
                data, connection.msgtype)]  # fmt: skip
        assert topics.count("/trials") == len(before) + 4
        assert mobo("bag", "compact", copy) == 0
