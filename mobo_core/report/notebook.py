"""A Jupyter notebook that reads a bag by the public API and draws the main pictures."""

from __future__ import annotations

import json

_CELLS = (
    (
        "markdown",
        "# {title}\n\nWritten by `mobo export notebook`. It reads the bag by mobo's public API: change what you like.",
    ),
    (
        "code",
        "import matplotlib.pyplot as plt\nimport mobo_core as mobo\n\nstudy = mobo.read_study({bag!r})\n"
        "table = mobo.study_table(study)\ntable",
    ),
    ("markdown", "## The trials\n\nReach counts voxels, torque is in N m, lengths are in m."),
    (
        "code",
        "frame = table.to_pandas().reset_index()\n"
        'frame[frame["on_front"]].sort_values("reach", ascending=False).head(20)',
    ),
    ("markdown", "## Sampling: every arm, coloured by its first four joints; the front ringed"),
    (
        "code",
        'good = frame[frame["state"] == "COMPLETE"].copy()\ngood["prefix"] = good["joints"].str[:4]\n'
        'shown = good["prefix"].value_counts().index[:8]\nfigure, axes = plt.subplots(figsize=(9, 6))\n'
        'rest = good[~good["prefix"].isin(shown)]\n'
        'axes.scatter(rest["reach"], rest["torque"], s=6, color="0.8", label="others")\n'
        "for prefix in shown:\n"
        '    arms = good[good["prefix"] == prefix]\n'
        '    axes.scatter(arms["reach"], arms["torque"], s=14, label=f"{{prefix}} ({{len(arms)}})")\n'
        'front = good[good["on_front"]]\n'
        'axes.scatter(front["reach"], front["torque"], s=70, facecolors="none", edgecolors="black")\n'
        'axes.set(xlabel=f"reach [of {{table.n_voxels}} voxels]", ylabel="torque [N m]")\naxes.legend();',
    ),
    ("markdown", "## Structures: the highest reach of each order of the first four joints"),
    (
        "code",
        'best = good.sort_values("reach", ascending=False).groupby("prefix", sort=False).head(1)\n'
        'best[["prefix", "trial", "joints", "reach", "torque"]].head(12)',
    ),
    ("markdown", "## Hypervolume over the trials"),
    (
        "code",
        "counts = sorted({{max(1, round(len(table.rows) * (i + 1) / 50)) for i in range(50)}})\n"
        "figure, axes = plt.subplots(figsize=(9, 3))\n"
        'axes.plot(counts, [table.hypervolume(count) for count in counts], drawstyle="steps-post")\n'
        'axes.set(xlabel="trials", ylabel="hypervolume [share of the box]");',
    ),
    ("markdown", "## One arm, evaluated again\n\nThe one of the highest reach, with what each of its joints holds."),
    (
        "code",
        "arm = study.candidate_of(int(best.iloc[0].trial))\n"
        "result = mobo.evaluate(arm.urdf, study.settings.spec, tip=arm.tip, joint_torques=True)\n"
        "print(result)\nfor joint in result.joint_torques:\n"
        '    print(f"{{joint.joint}}: mean {{joint.mean:.2f}}, peak {{joint.peak:.2f}} N m")',
    ),
    (
        "code",
        "voxels = result.to_pandas()\nheights = sorted(voxels.z.unique())\n"
        "figure, row = plt.subplots(1, len(heights), figsize=(3 * len(heights), 3), squeeze=False)\n"
        "for axes, z in zip(row[0], heights):\n"
        '    layer = voxels[voxels.z == z].pivot(index="y", columns="x", values="reach")\n'
        '    axes.imshow(layer, origin="lower", vmin=0, vmax=1, cmap="RdYlGn")\n    axes.set_title(f"z = {{z:.2f}} m")',
    ),
)


def notebook(name: str, bag: str) -> str:
    """Return a notebook of a study as the text of an ``.ipynb`` file (nbformat 4.5).

    Args:
        name: of the study.
        bag: where the notebook finds it.
    """
    title = f"`{' '.join(name.split()).replace('`', chr(39)) or 'a study'}`"  # as code: no part of it is Markdown
    cells = []
    for i, (kind, source) in enumerate(_CELLS):
        text = source.format(title=title, bag=bag)
        cell: dict[str, object] = {"cell_type": kind, "id": f"cell-{i}", "metadata": {}}
        cell["source"] = text.splitlines(keepends=True)
        cells.append(cell | ({"execution_count": None, "outputs": []} if kind == "code" else {}))
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    whole = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False) + "\n"
