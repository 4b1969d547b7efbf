"""Learn reach and torque of the paper's six-joint arms from the data of surrogate_data.py, and print the error.

The last chunks (one round of kinds, from which no other arm was bred) are held out. What is learnt is a few small
networks, whose weights go to a file beside the data; predicting takes NumPy alone. Learning takes
pip install torch
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from surrogate_data import FOLDER, KINDS, SPEC, Array, arm, load

from mobo_core.design import effective_joints

TORQUE_UNIT = 5.0  # N m, of a voxel's torque in a network
SCALE = np.array([10.0, 100.0])  # of reach and of torque (N m) in what is learnt from
WIDTHS = (384, 384, 384)
NETWORKS = 3
EPOCHS = 80
BATCH = 256
_CAPSULES_TOUCH = 0.03  # m, two link radii: links this near when stretched are never checked for collision


class Surrogate:
    """Predicts reach and torque of an arm: the mean of its networks.

    Each network says for every voxel the share of poses reached, whether any is, and the torque if so; reach and
    torque are their sums, and so always within what can be.

    Args:
        file: weights, as written by :func:`learn`.
    """

    def __init__(self, file: Path) -> None:
        data = np.load(file)
        self._mean, self._deviation = data["mean"], data["deviation"]
        layers = range(len(WIDTHS) + 1)
        self._networks = [
            [(data[f"w{n}_{i}"], data[f"b{n}_{i}"]) for i in layers] for n in range(int(data["networks"]))
        ]

    def __call__(self, joints: str, lengths: tuple[float, ...]) -> tuple[float, float]:
        """Return reach and torque (N m) of an arm by its joints as built and its lengths in metres."""
        reach, torque = self.predict(features([joints], np.array([lengths])))[0]
        return float(reach), float(torque)

    def predict(self, x: Array) -> Array:
        """Return reach and torque, shape (n, 2), from features."""
        x = ((x - self._mean) / self._deviation).astype(np.float32)
        total = np.zeros((len(x), 2))
        for layers in self._networks:
            hidden = x
            for weight, bias in layers[:-1]:
                hidden = hidden @ weight + bias
                hidden = hidden * _sigmoid(hidden)
            share, any_reached, torque = np.split(hidden @ layers[-1][0] + layers[-1][1], 3, axis=1)
            total[:, 0] += _sigmoid(share).sum(axis=1)
            total[:, 1] += (_sigmoid(any_reached) * np.logaddexp(0, torque)).sum(axis=1) * TORQUE_UNIT
        return total / len(self._networks)


def _sigmoid(x: Array) -> Array:
    return 0.5 + 0.5 * np.tanh(0.5 * x)


def features(joints: list[str], lengths: Array) -> Array:
    """Return what the networks see: joint types and pairs of them, lengths and heights, alone and by type.

    Args:
        joints: joint orders as built, six letters each.
        lengths: metres, shape (n, 6).
    """
    letters = np.frombuffer("".join(joints).encode(), np.uint8).reshape(len(joints), -1)
    types = (letters[:, :, None] == np.frombuffer(b"RPY", np.uint8)).astype(float)
    pairs = types[:, :-1, :, None] * types[:, 1:, None, :]
    heights = np.cumsum(lengths, axis=1) - lengths  # of each joint above the base, stretched
    two = lengths[:, :-1] + lengths[:, 1:]
    three = two[:, :-1] + lengths[:, 2:]
    columns = [
        types, pairs, lengths / 0.1, heights / 0.2,
        types * lengths[:, :, None] / 0.1, types * heights[:, :, None] / 0.2,
        lengths > 0, *(near for sums in (lengths, two, three)
                       for near in (sums > _CAPSULES_TOUCH, np.minimum(sums, _CAPSULES_TOUCH) / _CAPSULES_TOUCH)),
    ]  # fmt: skip
    return np.concatenate([np.asarray(column, float).reshape(len(joints), -1) for column in columns], axis=1)


def columns_of(data: dict[str, Array]) -> tuple[Array, Array]:
    """Return features, and reach and torque (n, 2), of arms evaluated."""
    designs = [arm(str(joints), tuple(u)) for joints, u in zip(data["joints"], data["u"].tolist(), strict=True)]
    x = features([effective_joints(d.sampled_joints) for d in designs], np.array([d.lengths for d in designs]))
    return x, np.stack([data["reach"], data["torque"]], axis=1)


def learn(data: dict[str, Array], file: Path, epochs: int) -> None:
    """Fit the networks, to the sums and to every voxel's answer at once, and write their weights."""
    import torch
    from torch import nn
    from torch.nn.functional import binary_cross_entropy_with_logits, smooth_l1_loss, softplus

    torch.set_num_threads(1)
    x, y = columns_of(data)
    mean, deviation = x.mean(axis=0), np.maximum(x.std(axis=0), 1e-3)
    inputs = torch.tensor((x - mean) / deviation, dtype=torch.float32)
    values = torch.tensor(y / SCALE, dtype=torch.float32)
    shares = torch.tensor(data["reached"] / SPEC.poses_per_voxel, dtype=torch.float32)
    torques = torch.tensor(data["voxel_torque"] / TORQUE_UNIT, dtype=torch.float32)
    reached = (shares > 0).float()
    weights: dict[str, Any] = {"mean": mean, "deviation": deviation, "networks": NETWORKS}
    for n in range(NETWORKS):
        torch.manual_seed(n)
        sizes = (x.shape[1], *WIDTHS)
        hidden = [part for a, b in zip(sizes, sizes[1:], strict=False) for part in (nn.Linear(a, b), nn.SiLU())]
        network = nn.Sequential(*hidden, nn.Linear(WIDTHS[-1], 3 * SPEC.n_voxels))
        optimizer = torch.optim.AdamW(network.parameters(), weight_decay=1e-3)
        steps = epochs * (len(x) // BATCH)
        schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, 3e-3, total_steps=steps, pct_start=0.1)
        for epoch in range(epochs):
            began, total = time.perf_counter(), 0.0
            for rows in _batches(torch.randperm(len(x))):
                share, any_reached, torque = network(inputs[rows]).chunk(3, dim=1)
                torque = softplus(torque)
                sums = torch.stack(
                    [torch.sigmoid(share).sum(1), TORQUE_UNIT * (torch.sigmoid(any_reached) * torque).sum(1)], dim=1
                )
                loss = smooth_l1_loss(sums / torch.tensor(SCALE, dtype=torch.float32), values[rows], beta=0.1)
                loss = loss + 0.5 * binary_cross_entropy_with_logits(share, shares[rows])
                loss = loss + 0.1 * binary_cross_entropy_with_logits(any_reached, reached[rows])
                loss = loss + 0.05 * ((torque - torques[rows]) ** 2 * reached[rows]).mean()
                optimizer.zero_grad()
                loss.backward()
                optimizer.step()
                schedule.step()
                total += float(loss)
            print(f"network {n}, epoch {epoch}: {total * BATCH / len(x):.4f}, {time.perf_counter() - began:.1f} s",
                  end="\r", flush=True)  # fmt: skip
        for i, layer in enumerate(part for part in network if isinstance(part, nn.Linear)):
            weights[f"w{n}_{i}"] = layer.weight.detach().numpy().T.copy()
            weights[f"b{n}_{i}"] = layer.bias.detach().numpy()
    print()
    np.savez(file, **weights)


def _batches(order: Any) -> Iterator[Any]:
    for i in range(len(order) // BATCH):
        yield order[i * BATCH : (i + 1) * BATCH]


def report(surrogate: Surrogate, data: dict[str, Array]) -> None:
    """Print the errors on arms held out, in all, by kind of chunk, and of the better ones."""
    x, y = columns_of(data)
    error = surrogate.predict(x) - y
    kinds = np.array(KINDS)[data["chunk"] % len(KINDS)]
    print("| held-out arms | number | reach: MAE | RMSE | torque, N m: MAE | RMSE | mean error of both |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    rows = [("all", np.ones(len(x), bool))] + [(kind, kinds == kind) for kind in dict.fromkeys(KINDS)]
    rows += [(f"reach above {least}", y[:, 0] > least) for least in (20, 30, 40)]
    for name, chosen in rows:
        e = error[chosen]
        if not len(e):
            continue
        mae, rmse = np.abs(e).mean(axis=0), np.sqrt((e * e).mean(axis=0))
        bias = ", ".join(f"{value:+.2f}" for value in e.mean(axis=0))
        print(f"| {name} | {len(e)} | {mae[0]:.2f} | {rmse[0]:.2f} | {mae[1]:.1f} | {rmse[1]:.1f} | {bias} |")


def main() -> None:
    """Learn if there are no weights yet, and print the errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folder", type=Path, default=FOLDER)
    parser.add_argument("--held-out", type=int, default=len(KINDS), help="chunks, the last ones")
    parser.add_argument("--epochs", type=int, default=EPOCHS)
    parser.add_argument("--again", action="store_true", help="learn even if there are weights")
    args = parser.parse_args()
    files = sorted(args.folder.glob("[0-9][0-9][0-9].npz"))
    weights = args.folder / "weights.npz"
    held_out = load(files[-args.held_out :])
    if args.again or not weights.exists():
        data = load(files[: -args.held_out])
        print(f"{len(data['reach'])} arms to learn from")
        learn(data, weights, args.epochs)
    surrogate = Surrogate(weights)
    report(surrogate, held_out)
    design = arm("PRRYPY", (0.2, 0.9, 0.6, 0.5, 0.1))
    times = []
    for _ in range(200):
        began = time.perf_counter()
        surrogate(design.joints, design.lengths)
        times.append(time.perf_counter() - began)
    print(f"\none arm: {1e6 * sorted(times)[100]:.0f} µs (median of 200)")


if __name__ == "__main__":
    main()
