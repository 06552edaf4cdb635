"""Lays the frames of several renderers beside one another: bias of converged frames, error and time of
the others. Reads what `render_*.py` and `cargo bench --bench peer_frames` left in a folder.

Errors are relative MSE over linear RGB, (x - y)^2 / (y^2 + e^2), y being our most exact frame and e 1 % of
its mean over the pixels that the sphere or its shadow touches. The ball is the rectangle around all
that the sphere covers while the shutter is open.
"""

import argparse
import csv
import math
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scene

TARGET_RELATIVE_MSE = 1e-3
TARGET_DB = 40.0
LARGEST_BIAS = 0.01
EVERYWHERE = (slice(None), slice(None))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    scene.add_view_arguments(parser)
    parser.add_argument("--ours", default="ours-gpu", help="whose most exact frame is the truth")
    parser.add_argument("--differences", type=Path, metavar="DIR", help="write images of the bias")
    given = parser.parse_args()
    view = scene.view(given)
    name = view.name()
    frames, times = load(given.folder, name), load_times(given.folder, name)
    finest = max((n for n, images in frames[given.ours].items() if len(images) > 1), default=None)
    if finest is None:
        raise SystemExit(f"error: {given.folder}: no two seeds of {given.ours} for {name}")
    ours = halves(frames[given.ours].pop(finest))
    eps = epsilon((ours[0] + ours[1]) / 2, scene.read_pfm(given.folder / f"empty_{name}.pfm"))

    print(f"{name}: against {given.ours} with 2 x {finest} samples")
    print_biases(frames, ours, eps, view.ball())
    print_errors(frames, times, ours, eps, view.ball())
    if given.differences:
        given.differences.mkdir(parents=True, exist_ok=True)
        for renderer, theirs in converged(frames):
            path = given.differences / f"{renderer}_{name}.pfm"
            write_difference(path, theirs, ours, eps)


def print_biases(frames, ours, eps, ball):
    columns = " ".join(f"{title:>8}" for title in ("bias", "below", "ball", "below", "mean", "ball"))
    print(f"{'converged':24} {columns}")
    for renderer, theirs in converged(frames):
        measured = [bias(theirs, ours, eps, part) for part in (EVERYWHERE, ball)]
        biases = " ".join(f"{b.root:8.2%} {b.upper:8.2%}" for b in measured)
        means = " ".join(f"{b.mean_ratio:8.4f}" for b in measured)
        if all(b.upper < LARGEST_BIAS for b in measured):
            verdict = "agrees"
        elif any(b.lower > LARGEST_BIAS for b in measured):
            verdict = "differs"
        else:
            verdict = "undecided, too few samples"
        print(f"{renderer:24} {biases} {means}  {verdict}")


def print_errors(frames, times, ours, eps, ball):
    print(f"{'time and error':24} samples   wall s   core s "
          "Mpaths/core-s relative MSE  in the ball  ball dB")
    for renderer, by_samples in sorted(frames.items()):
        ladder = []
        for samples, images in sorted(by_samples.items()):
            wall, core = times[renderer, samples]
            error, in_ball = (
                np.mean([relative_mse(image, ours, eps, part) for image in images])
                for part in (EVERYWHERE, ball)
            )
            decibels = np.mean([psnr(image, ours, ball) for image in images])
            ladder.append((wall, core, error, decibels))
            paths = scene.WIDTH * scene.HEIGHT * samples / core / 1e6
            print(f"{renderer:24} {samples:7} {wall:8.3f} {core:8.3f} {paths:13.2f} "
                  f"{error:12.3e} {in_ball:12.3e} {decibels:8.2f}")
        if len(ladder) > 1:
            print_times_to_targets(*map(np.array, zip(*ladder)))


def print_times_to_targets(walls, cores, errors, decibels):
    wanted = -10 * math.log10(TARGET_RELATIVE_MSE)
    for what, levels, target in (
        (f"a relative MSE of {TARGET_RELATIVE_MSE}", -10 * np.log10(errors), wanted),
        (f"{TARGET_DB:.0f} dB in the ball", decibels, TARGET_DB),
    ):
        wall, core = (when_reached(amounts, levels, target) for amounts in (walls, cores))
        outside = "" if min(levels) <= target <= max(levels) else " (extrapolated)"
        print(f"    to {what}: {wall:.2f} s, {core:.2f} core-seconds{outside}")


def converged(frames):
    """Of each renderer the frame with the most samples that was rendered with two seeds, as halves."""
    for renderer, by_samples in sorted(frames.items()):
        finest = max((n for n, images in by_samples.items() if len(images) > 1), default=None)
        if finest is not None:
            yield renderer, halves(by_samples[finest])


def load(folder, view):
    """renderer -> samples -> images, one for each seed."""
    frames = defaultdict(lambda: defaultdict(list))
    for path in sorted(folder.glob(f"*_{view}_*_*.pfm")):
        renderer, _, samples, _ = path.stem.split("_")
        frames[renderer][int(samples)].append(scene.read_pfm(path))
    return frames


def load_times(folder, view):
    """(renderer, samples) -> median seconds of wall and of processor time."""
    times = defaultdict(list)
    with open(folder / "times.csv") as file:
        for renderer, name, samples, _, wall, core in csv.reader(file):
            if name == view:
                times[renderer, int(samples)].append((float(wall), float(core)))
    return {key: np.median(values, axis=0) for key, values in times.items()}


def epsilon(truth, empty):
    touched = np.any(np.abs(truth - empty) > 0.01 * empty, axis=-1)
    return 0.01 * (truth[touched].mean() if touched.any() else truth.mean())


def halves(images):
    """Two independent estimates of the same frame."""
    return np.mean(images[0::2], axis=0), np.mean(images[1::2], axis=0)


@dataclass(frozen=True)
class Bias:
    root: float
    lower: float
    upper: float
    mean_ratio: float


def bias(theirs, ours, eps, part):
    """The root of the relative MSE without the noise of either, its bounds at two standard errors (each 0
    where chance puts the square below), and the ratio of the means.

    The product of two independent differences is the squared difference less its variance as the two
    halves estimate it: ((a + b) / 2)^2 - ((a - b) / 2)^2 = a b.
    """
    truth = ((ours[0] + ours[1]) / 2)[part]
    products = (theirs[0] - ours[0])[part] * (theirs[1] - ours[1])[part] / (truth**2 + eps**2)
    # The channels of a pixel share their noise.
    products = products.mean(axis=-1)
    square, error = products.mean(), products.std() / math.sqrt(products.size)
    squares = square, square - 2 * error, max(square, 0) + 2 * error
    mean_ratio = ((theirs[0] + theirs[1]) / 2)[part].mean() / truth.mean()
    return Bias(*(math.sqrt(max(value, 0)) for value in squares), mean_ratio)


def relative_mse(image, ours, eps, part):
    truth = ((ours[0] + ours[1]) / 2)[part]
    of_truth = ((ours[0] - ours[1]) / 2)[part] ** 2
    return (((image[part] - truth) ** 2 - of_truth) / (truth**2 + eps**2)).mean()


def psnr(image, ours, part):
    truth = ((ours[0] + ours[1]) / 2)[part]
    return -10 * math.log10(((shown(image[part]) - shown(truth)) ** 2).mean())


def shown(image):
    """As a participant sees it: sRGB at exposure 0, not rounded to 8 bits."""
    x = np.clip(image, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def when_reached(amounts, decibels, target):
    """Where the level is reached: on a straight line between the logarithms of two amounts measured, those
    on either side of it, or else the two nearest it."""
    x = np.log(amounts)
    after = int(np.clip(np.searchsorted(decibels, target), 1, len(x) - 1))
    a, b = decibels[after - 1], decibels[after]
    return math.exp(x[after - 1] + (target - a) / (b - a) * (x[after] - x[after - 1]))


def write_difference(path, theirs, ours, eps):
    """Their frame less ours over ours, 0 as middle grey and 5 % as white."""
    truth = (ours[0] + ours[1]) / 2
    difference = (sum(theirs) / 2 - truth) / np.sqrt(truth**2 + eps**2)
    scene.write_pfm(path, 0.5 + difference / 0.1)


if __name__ == "__main__":
    main()
