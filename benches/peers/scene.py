"""The rolling sphere of the thesis in numbers, for renderers that are not ours, and what their scripts
have in common: arguments, names of frames, Portable Float Maps. It knows no renderer. Called with the name
of a file it writes the mesh there.

Metres, seconds, right-handed, y up. The same numbers stand in stimuli/scenes/rolling-sphere.toml,
the grids rolling-sphere-mono.toml and rolling-sphere-stereo.toml, and stimuli/src/stimulus.rs.
"""

import argparse
import math
import os
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

WIDTH, HEIGHT = 640, 360
FPS, FRAMES = 30.0, 120
CAMERA, LOOK_AT = np.array([0.0, 0.5, 3.0]), np.array([0.0, 0.1, 0.0])
# How far to the right each eye is. Both look at the same point.
EYES = {"": 0.0, "left": -0.0325, "right": 0.0325}
FOCAL_LENGTH_MM, SENSOR_WIDTH_MM = 50.0, 36.0
RADIUS = 0.1
FLOOR_ALBEDO, FLOOR_SIDE = 0.5, 200.0
MAX_HITS = 5
IMAGE_WIDTH_DEG = 14.4
SPEEDS_DEG_PER_S = {"S1": 5.0, "S2": 10.0, "S3": 15.0}
SHUTTERS = {"T1": 0.0, "T2": 0.25, "T3": 0.5, "T4": 0.75, "T5": 1.0}
# Cells around the equator (0: one albedo), and the albedos of light and dark cells.
MATERIALS = {
    "flat": (0, (0.80, 0.25, 0.15), None),
    "checker8": (8, (0.8, 0.8, 0.8), (0.1, 0.1, 0.1)),
    "checker16": (16, (0.8, 0.8, 0.8), (0.1, 0.1, 0.1)),
    # The mesh in place of the sphere.
    "mesh": (0, (0.80, 0.25, 0.15), None),
}
SUN_DIRECTION = np.array([-0.4393850, 0.6427876, 0.6275069])

FOCAL_LENGTH_PX = FOCAL_LENGTH_MM / SENSOR_WIDTH_MM * WIDTH
PIXELS_PER_METRE = FOCAL_LENGTH_PX / np.linalg.norm(CAMERA - LOOK_AT)


@dataclass(frozen=True)
class View:
    """One frame of one stimulus."""

    material: str = "checker8"
    speed: str = "S2"
    shutter: str = "T5"
    frame: int = 60
    eye: str = ""

    def name(self):
        name = f"{self.material}-{self.speed}-{self.shutter}-{self.frame}"
        return f"{name}-{self.eye}" if self.eye else name

    @property
    def is_mesh(self):
        return self.material == "mesh"

    @property
    def camera(self):
        return CAMERA + [EYES[self.eye], 0.0, 0.0]

    @property
    def shutter_open(self):
        return SHUTTERS[self.shutter]

    @property
    def metres_per_second(self):
        return SPEEDS_DEG_PER_S[self.speed] * WIDTH / IMAGE_WIDTH_DEG / PIXELS_PER_METRE

    def sphere(self, shutter=0.0):
        """x of the centre, and the angle rolled about -z, when the part `shutter` in [-1/2, 1/2] of the
        shutter interval has passed, counted from its middle. Whole periods are taken off x per frame;
        the angle follows the unwrapped distance."""
        step = self.metres_per_second / FPS
        covered = step * (self.frame - FRAMES / 2)
        period = 2 * (0.5 * WIDTH / PIXELS_PER_METRE + RADIUS + step)
        moved = step * self.shutter_open * shutter
        x = covered - period * round(covered / period) + moved
        return x, (covered + moved) / RADIUS

    def travel_px(self):
        """Screen velocity: pixels per shutter."""
        return self.metres_per_second / FPS * self.shutter_open * PIXELS_PER_METRE

    def ball(self):
        """The rectangle (rows, columns) around all that the sphere covers while the shutter is open."""
        forward = (LOOK_AT - self.camera) / np.linalg.norm(LOOK_AT - self.camera)
        right = np.cross(forward, [0.0, 1.0, 0.0])
        right /= np.linalg.norm(right)
        up = np.cross(right, forward)
        directions = np.random.default_rng(0).normal(size=(4000, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        centers = [np.array([self.sphere(s)[0], RADIUS, 0.0]) for s in (-0.5, 0.5)]
        points = np.concatenate([center + RADIUS * directions for center in centers]) - self.camera
        depth = points @ forward
        columns = 0.5 * WIDTH + FOCAL_LENGTH_PX * (points @ right) / depth
        rows = 0.5 * HEIGHT - FOCAL_LENGTH_PX * (points @ up) / depth
        return tuple(
            slice(max(math.floor(places.min()) - 1, 0), min(math.ceil(places.max()) + 1, size))
            for places, size in ((rows, HEIGHT), (columns, WIDTH))
        )


def uv_sphere(around, between_poles):
    """Unit vectors, ring by ring from the pole n_y = 1, along u within a ring; and the faces between them in
    the same order, counter-clockwise seen from outside. Of a pole's ring, which is one point, the first is used.
    """
    vertices, faces = [], []
    for j in range(between_poles + 1):
        polar = math.pi * j / between_poles
        for i in range(around):
            azimuth = 2 * math.pi * i / around
            x, z = math.cos(azimuth), -math.sin(azimuth)
            vertices.append((math.sin(polar) * x, math.cos(polar), math.sin(polar) * z))
    for j in range(between_poles):
        for i in range(around):
            right = (i + 1) % around
            upper, lower = j * around, (j + 1) * around
            corners = [upper + i, lower + i, lower + right, upper + right]
            if j == 0:
                corners = [0] + corners[1:3]
            elif j == between_poles - 1:
                corners = [corners[0], between_poles * around, corners[3]]
            faces.append(corners)
    return vertices, faces


def bumpy_mesh():
    """Vertices and triangles of a closed mesh with bumps of many sizes. The middle of its bounding box is the
    origin and its farthest vertex is at RADIUS, so that to fit it to these leaves it as it is."""
    vertices, faces = uv_sphere(264, 134)
    vertices = np.array(vertices)
    random = np.random.default_rng(2012)
    height = np.zeros(len(vertices))
    for octave in range(5):
        waves, phases = random.normal(size=(3, 8)), random.uniform(0, 2 * math.pi, 8)
        height += np.sin(3 * 2**octave * (vertices @ waves) + phases).mean(axis=1) / 2**octave
    vertices *= np.exp(0.35 * height)[:, None]
    vertices -= (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    vertices *= RADIUS / np.linalg.norm(vertices, axis=1).max()
    triangles = [(face[0], *pair) for face in faces for pair in zip(face[1:], face[2:])]
    return vertices.astype(np.float32), np.array(triangles, np.int32)


def write_mesh(path):
    vertices, triangles = bumpy_mesh()
    faces = np.zeros(len(triangles), [("corners", "u1"), ("vertices", "<i4", 3)])
    faces["corners"], faces["vertices"] = 3, triangles
    header = f"""ply
format binary_little_endian 1.0
element vertex {len(vertices)}
property float x
property float y
property float z
element face {len(faces)}
property list uchar int vertex_indices
end_header
"""
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + faces.tobytes())


def checker(cells):
    """Whether a cell is light: row by row from the pole n_y = 1, along u."""
    return np.add.outer(np.arange(cells // 2), np.arange(cells)) % 2 == 0


def directions(width, height, rows_end_at_poles=False):
    """The directions of a light map's texels, row by row from the zenith. A texel's value is that of its
    centre; with `rows_end_at_poles` the first and last rows are the poles themselves."""
    if rows_end_at_poles:
        row = np.arange(height) / (height - 1)
    else:
        row = (np.arange(height) + 0.5) / height
    elevation = (0.5 - row[:, None]) * math.pi
    azimuth = (0.5 - (np.arange(width)[None, :] + 0.5) / width) * 2 * math.pi
    cosine = np.cos(elevation)
    y = np.sin(elevation) * np.ones_like(azimuth)
    return np.stack([cosine * np.cos(azimuth), y, -cosine * np.sin(azimuth)], axis=-1)


def clear_sky(d):
    """Radiance of the built-in clear sky from directions `d`."""
    y = d[..., 1:2]
    zenith = 1 - np.exp(-5 * np.maximum(y, 0))
    t = np.clip((y + 0.02) / 0.04, 0, 1)
    above = t * t * (3 - 2 * t)
    sun = (d @ SUN_DIRECTION)[..., None] - 1
    ground = np.array([0.22, 0.19, 0.15])
    sky = np.array([0.85, 0.92, 1.0]) * (1 - zenith) + np.array([0.18, 0.32, 0.75]) * zenith
    disc = np.array([160.0, 145.0, 120.0]) * np.exp(600 * sun)
    aureole = np.array([0.8, 0.7, 0.5]) * np.exp(20 * sun)
    return ground * (1 - above) + sky * above + disc + aureole


def read_pfm(path):
    """Rows from the top, linear RGB."""
    with open(path, "rb") as file:
        kind, size, scale = (file.readline().split() for _ in range(3))
        if kind != [b"PF"]:
            raise ValueError(f"{path}: {kind}, only colour maps (PF) are read")
        width, height = map(int, size)
        values = np.fromfile(file, "<f4" if float(scale[0]) < 0 else ">f4", 3 * width * height)
    return values.reshape(height, width, 3)[::-1].astype(np.float64)


def write_pfm(path, image):
    with open(path, "wb") as file:
        file.write(f"PF\n{image.shape[1]} {image.shape[0]}\n-1.0\n".encode())
        file.write(np.ascontiguousarray(image[::-1], "<f4").tobytes())


def arguments(description, samplers):
    """The command line that the renderers' scripts share: one view, some numbers of samples and seeds."""
    numbers = lambda text: [int(number) for number in text.split(",")]
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR")
    add_view_arguments(parser)
    parser.add_argument("--samples", type=numbers, default=[4, 32, 128], metavar="N,...")
    parser.add_argument("--seeds", type=numbers, default=[1], metavar="N,...")
    parser.add_argument("--sampler", choices=samplers, default=samplers[0])
    return parser


def add_view_arguments(parser):
    parser.add_argument("--material", choices=MATERIALS, default=View.material)
    parser.add_argument("--speed", choices=SPEEDS_DEG_PER_S, default=View.speed)
    parser.add_argument("--shutter", choices=SHUTTERS, default=View.shutter)
    parser.add_argument("--frame", type=int, default=View.frame)
    parser.add_argument("--eye", choices=EYES, default=View.eye)


def view(given):
    return View(given.material, given.speed, given.shutter, given.frame, given.eye)


def render_all(given, renderer, render):
    """Calls `render(samples, seed)` for an image, once uncounted, then for all samples and seeds; writes
    `RENDERER_VIEW_SAMPLES_SEED.pfm`, and prints and keeps the time of each as a line of CSV."""
    given.output.mkdir(parents=True, exist_ok=True)
    # What the renderer itself has to say goes to stderr.
    sys.stdout = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    render(given.samples[0], 0)
    name = view(given).name()
    for samples in given.samples:
        for seed in given.seeds:
            wall, core = time.perf_counter(), time.process_time()
            image = render(samples, seed)
            wall, core = time.perf_counter() - wall, time.process_time() - core
            write_pfm(given.output / f"{renderer}_{name}_{samples}_{seed}.pfm", image)
            line = f"{renderer},{name},{samples},{seed},{wall:.4f},{core:.4f}"
            print(line, flush=True)
            with open(given.output / "times.csv", "a") as file:
                file.write(line + "\n")


if __name__ == "__main__":
    write_mesh(Path(sys.argv[1]))
