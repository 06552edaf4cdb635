"""Holds what `shutterlab screen` says of pairs of sequences against ColorVideoVDP by its authors.

    python3 -m venv target/cvvdp
    target/cvvdp/bin/pip install cvvdp==0.5.7 imageio
    target/cvvdp/bin/python benches/peers/cvvdp.py DIR

DIR is the folder that `screen` compared. Per pair it prints the units of just objectionable difference of
`screen.csv`, the authors' from the same luminances, and the authors' from the sRGB code values as they
are, to which their model of a display adds the black that `screen` only does not go below.
"""

import argparse
import csv
import json
from pathlib import Path

import imageio.v3 as imageio
import numpy as np
import pycvvdp

# As in stimuli/src/screen.rs.
WHITE_LUMINANCE = 100.0
CONTRAST = 1000.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    largest = 0.0
    print(f"{'pair':32} {'screen':>9} {'authors':>9} {'from sRGB':>9}")
    with open(folder / "screen.csv", newline="") as file:
        for row in csv.DictReader(file):
            reference, test = (Sequence(folder / row[side]) for side in ("reference", "test"))
            ours = float(row["cvvdp_jod"])
            theirs = [compare(reference, test, space) for space in ("BT.709-linear", "sRGB")]
            largest = max(largest, abs(theirs[0] - ours))
            pair = f"{row['reference']} {row['test']}"
            print(f"{pair:32} {ours:9.5f} {theirs[0]:9.5f} {theirs[1]:9.5f}", flush=True)
    print(f"largest difference: {largest:.6f}")


class Sequence:
    def __init__(self, folder):
        manifest = json.loads((folder / "sequence.json").read_text())
        self.stimulus = manifest["stimulus"]
        if self.stimulus["image"]["transfer"] != "srgb":
            raise SystemExit(f"error: {folder}: transfer: {self.stimulus['image']['transfer']}: srgb is known")
        display = self.stimulus["viewing"].get("display") or {}
        self.white = display.get("white_luminance_cd_m2") or WHITE_LUMINANCE
        files = [folder / f"frame-{frame['index']:04}.png" for frame in manifest["frames"]]
        self.codes = np.stack([imageio.imread(file) for file in files])

    def frames(self, space):
        """What the metric takes in this colour space, as frame, row, column, channel."""
        if space == "sRGB":
            return self.codes
        codes = np.arange(256) / 255
        light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
        return (self.white * light).astype(np.float32)[self.codes]


def compare(reference, test, space):
    height, width = reference.codes.shape[1:3]
    photometry = pycvvdp.vvdp_display_photo_eotf(
        Y_peak=reference.white, contrast=CONTRAST, source_colorspace=space, E_ambient=0, k_refl=0
    )
    ppd = reference.stimulus["pixels_per_degree"]
    geometry = pycvvdp.vvdp_display_geometry([width, height], ppd=ppd)
    metric = pycvvdp.cvvdp(display_photometry=photometry, display_geometry=geometry, quiet=True)
    jod, _ = metric.predict(
        test.frames(space),
        reference.frames(space),
        dim_order="FHWC",
        frames_per_second=reference.stimulus["image"]["fps"],
    )
    return float(jod)


if __name__ == "__main__":
    main()
