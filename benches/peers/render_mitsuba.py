"""Renders the rolling sphere with Mitsuba 3 (llvm_ad_rgb) and tells the time of rendering alone.

Mitsuba moves no shape while its shutter is open, so motion blur is the mean of sub-frames, each an
instant at the middle of its part of the shutter interval; their number divides the samples.
"""

import math
import os
from pathlib import Path

import numpy as np
import scene

# What `setup` found, if no other is named: read when drjit is imported.
LLVM = Path(__file__).resolve().parents[2] / "target/peers/llvm-path"
os.environ.setdefault("DRJIT_LIBLLVM_PATH", LLVM.read_text().strip())
import drjit as dr
import mitsuba as mi

mi.set_variant("llvm_ad_rgb")
from mitsuba import ScalarTransform4f as Transform

# Mitsuba's sphere has its poles on z: turn them onto our y.
POLES_TO_Y = Transform().rotate([1, 0, 0], -90)
# A row of Mitsuba's light map begins at -z and goes on towards +x; ours begins at -x and goes on towards -z.
SKY_TO_WORLD = Transform().rotate([0, 1, 0], 90)


def main():
    parser = scene.arguments(__doc__, ["independent", "multijitter"])
    parser.add_argument("--sub-frames", type=int, default=0, help="default: one per pixel of travel")
    given = parser.parse_args()
    view = scene.view(given)
    built = build(view, given.sampler, given.output / "mesh.ply")
    parameters = mi.traverse(built)

    def render(samples, seed):
        count = sub_frames(view, samples, given.sub_frames)
        total = 0
        for k in range(count):
            if count > 1:
                shutter = (k + 0.5) / count - 0.5
                parameters["sphere.to_world"] = mi.Transform4f(sphere_to_world(view, shutter))
                parameters.update()
            # To `multijitter` a seed is an offset in pixels: near seeds give neighbours the same noise.
            far = int(np.random.default_rng([seed, k]).integers(1 << 32))
            total = total + mi.render(built, spp=samples // count, seed=far).array
            dr.eval(total)
        image = np.array(total, dtype=np.float64) / count
        return image.reshape(scene.HEIGHT, scene.WIDTH, 3)

    scene.render_all(given, f"mitsuba-{given.sampler}", render)


def sub_frames(view, samples, wanted):
    """As many as wanted, by default one for each pixel of travel, or the next divisor of the samples."""
    wanted = wanted or max(math.ceil(view.travel_px()), 1)
    return next(n for n in range(1, samples + 1) if samples % n == 0 and n >= min(wanted, samples))


def build(view, sampler, mesh):
    sky = scene.clear_sky(scene.directions(1024, 512, rows_end_at_poles=True))
    return mi.load_dict({
        "type": "scene",
        # Depth counts the light too.
        "integrator": {"type": "path", "max_depth": scene.MAX_HITS + 1, "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": math.degrees(2 * math.atan(0.5 * scene.SENSOR_WIDTH_MM / scene.FOCAL_LENGTH_MM)),
            "fov_axis": "x",
            "near_clip": 0.01,
            "far_clip": 1000.0,
            "to_world": Transform().look_at(list(view.camera), list(scene.LOOK_AT), [0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": scene.WIDTH,
                "height": scene.HEIGHT,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": sampler},
        },
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(sky.astype(np.float32)),
            "to_world": SKY_TO_WORLD,
        },
        "floor": {
            "type": "rectangle",
            "to_world": Transform().rotate([1, 0, 0], -90).scale(0.5 * scene.FLOOR_SIDE),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": scene.FLOOR_ALBEDO}},
        },
        **moving(view, mesh),
    })


def moving(view, mesh):
    """What moves, as `sphere`. A mesh is an instance, so that its own hierarchy is built only once."""
    place = {"to_world": sphere_to_world(view, 0)}
    bsdf = {"type": "diffuse", "reflectance": reflectance(view.material)}
    if not view.is_mesh:
        return {"sphere": {"type": "sphere", **place, "bsdf": bsdf}}
    model = {"type": "ply", "filename": str(mesh), "face_normals": True, "bsdf": bsdf}
    return {
        "group": {"type": "shapegroup", "model": model},
        "sphere": {"type": "instance", **place, "group": {"type": "ref", "id": "group"}},
    }


def sphere_to_world(view, shutter):
    x, angle = view.sphere(shutter)
    place = Transform().translate([x, scene.RADIUS, 0])
    rolled = Transform().rotate([0, 0, -1], math.degrees(angle))
    if view.is_mesh:
        return place @ rolled
    return place @ rolled @ Transform().scale(scene.RADIUS) @ POLES_TO_Y


def reflectance(material):
    cells, light, dark = scene.MATERIALS[material]
    if not cells:
        return {"type": "rgb", "value": list(light)}
    # One texel is one cell, and the nearest texel is taken.
    texels = np.where(scene.checker(cells)[..., None], light, dark).astype(np.float32)
    return {"type": "bitmap", "bitmap": mi.Bitmap(texels), "filter_type": "nearest", "raw": True}


if __name__ == "__main__":
    main()
