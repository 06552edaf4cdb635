"""Renders the rolling sphere with Blender's Cycles and tells the time of rendering alone.

Blender has z up: our (x, y, z) is its (x, -z, y).
"""

import math
import os
import tempfile

import bpy
import mathutils
import numpy as np
import scene

# The sphere is a mesh, smoothly shaded; all of a checker's cells end at its edges.
AROUND, BETWEEN_POLES = 256, 128


def main():
    given = scene.arguments(__doc__, ["sobol"]).parse_args()
    view = scene.view(given)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_floor()
    sphere = add_mesh() if view.is_mesh else add_sphere(view.material)
    add_camera(view)
    add_sky()
    settings(view)
    move(sphere, view)
    bpy.context.scene.frame_set(view.frame)

    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "frame.exr")

        def render(samples, seed):
            made = bpy.context.scene
            made.cycles.samples, made.cycles.seed = samples, seed
            made.render.filepath = path
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(path)
            image.colorspace_settings.name = "Non-Color"
            values = np.empty(4 * scene.WIDTH * scene.HEIGHT, np.float32)
            image.pixels.foreach_get(values)
            bpy.data.images.remove(image)
            return values.reshape(scene.HEIGHT, scene.WIDTH, 4)[::-1, :, :3]

        scene.render_all(given, "cycles-sobol", render)


def settings(view):
    made = bpy.context.scene
    made.frame_set(view.frame)
    render, cycles = made.render, made.cycles
    render.engine, cycles.device = "CYCLES", "CPU"
    render.resolution_x, render.resolution_y, render.resolution_percentage = scene.WIDTH, scene.HEIGHT, 100
    render.fps = int(scene.FPS)
    render.use_motion_blur = view.shutter_open > 0
    render.motion_blur_shutter, render.motion_blur_position = view.shutter_open or 1, "CENTER"
    render.use_compositing = render.use_sequencer = False
    render.use_persistent_data = True
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode, render.image_settings.color_depth = "RGB", "32"
    render.image_settings.exr_codec = "NONE"
    made.view_settings.view_transform, made.view_settings.look = "Raw", "None"
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.use_light_tree = False
    cycles.use_auto_tile = False
    # Bounces come after the first hit. No Russian roulette before the last.
    cycles.max_bounces = cycles.diffuse_bounces = cycles.min_light_bounces = scene.MAX_HITS - 1
    cycles.sampling_pattern = "TABULATED_SOBOL"


def add_floor():
    half = 0.5 * scene.FLOOR_SIDE
    corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
    add_object("floor", corners, [(0, 1, 2, 3)], [diffuse("floor", [scene.FLOOR_ALBEDO] * 3)])


def add_sphere(material):
    normals, faces = scene.uv_sphere(AROUND, BETWEEN_POLES)
    vertices = [[scene.RADIUS * c for c in to_blender(n)] for n in normals]
    cells, light, dark = scene.MATERIALS[material]
    materials = [diffuse("light", light)] + ([diffuse("dark", dark)] if cells else [])
    sphere = add_object("sphere", vertices, faces, materials)
    # A material for each cell: no texture, and nothing to filter.
    if cells:
        rings = np.arange(BETWEEN_POLES) * (cells // 2) // BETWEEN_POLES
        columns = np.arange(AROUND) * cells // AROUND
        dark_faces = ~scene.checker(cells)[np.ix_(rings, columns)]
        sphere.data.polygons.foreach_set("material_index", dark_faces.ravel().astype(np.int32))
    sphere.data.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    sphere.data.update()
    return sphere


def add_mesh():
    vertices, triangles = scene.bumpy_mesh()
    vertices = [to_blender(v) for v in vertices.tolist()]
    materials = [diffuse("mesh", scene.MATERIALS["mesh"][1])]
    mesh = add_object("mesh", vertices, triangles.tolist(), materials)
    mesh.data.polygons.foreach_set("use_smooth", np.zeros(len(triangles), bool))
    mesh.data.update()
    return mesh


def move(sphere, view):
    """Keys a frame's time before and after, with nothing but straight lines between."""
    # The parts of the shutter interval that correspond to one frame's time before and after.
    reach = 1 / view.shutter_open if view.shutter_open else 0
    for offset in (-1, 0, 1):
        x, angle = view.sphere(offset * reach)
        sphere.location = to_blender((x, scene.RADIUS, 0))
        # -z is Blender's y.
        sphere.rotation_euler = (0, angle, 0)
        if view.shutter_open:
            sphere.keyframe_insert("location", frame=view.frame + offset)
            sphere.keyframe_insert("rotation_euler", frame=view.frame + offset)
    if view.shutter_open:
        for bag in sphere.animation_data.action.layers[0].strips[0].channelbags:
            for key in (key for curve in bag.fcurves for key in curve.keyframe_points):
                key.interpolation = "LINEAR"
    else:
        x, angle = view.sphere()
        sphere.location, sphere.rotation_euler = to_blender((x, scene.RADIUS, 0)), (0, angle, 0)
    # 2^(steps - 1) parts, each turned at one angular velocity.
    sphere.cycles.use_motion_blur = True
    sphere.cycles.motion_steps = 4
    for part in (-0.5, -0.3, 0.0, 0.5):
        at = view.frame + part * view.shutter_open
        bpy.context.scene.frame_set(math.floor(at), subframe=at - math.floor(at))
        x, angle = view.sphere(part)
        if abs(sphere.location.x - x) > 1e-6 or abs(sphere.rotation_euler.y - angle) > 1e-5:
            found = sphere.location.x, sphere.rotation_euler.y
            raise SystemExit(f"error: sphere: {found} at {part} of the shutter, not {(x, angle)}")


def add_camera(view):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_width, lens.lens = "HORIZONTAL", scene.SENSOR_WIDTH_MM, scene.FOCAL_LENGTH_MM
    lens.clip_start, lens.clip_end = 0.01, 1000.0
    camera = bpy.data.objects.new("camera", lens)
    bpy.context.collection.objects.link(camera)
    camera.location = to_blender(view.camera)
    # A camera of Blender looks along its -z, and its y is up in the image.
    ahead = mathutils.Vector(to_blender(scene.LOOK_AT - view.camera))
    camera.rotation_euler = ahead.to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = camera


def add_sky():
    width, height = 1024, 512
    sky = bpy.data.images.new("sky", width, height, float_buffer=True, is_data=True)
    texels = np.ones((height, width, 4), np.float32)
    # An image's rows go from the bottom.
    texels[..., :3] = scene.clear_sky(scene.directions(width, height))[::-1]
    sky.pixels.foreach_set(texels.ravel())
    sky.update()
    world = bpy.data.worlds.new("world")
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    texture = nodes.new("ShaderNodeTexEnvironment")
    background, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    texture.image, texture.projection, texture.interpolation = sky, "EQUIRECTANGULAR", "Linear"
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs[0], output.inputs["Surface"])
    world.cycles.sampling_method, world.cycles.sample_map_resolution = "MANUAL", width
    bpy.context.scene.world = world


def add_object(name, vertices, faces, materials):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    for material in materials:
        mesh.materials.append(material)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(made)
    return made


def diffuse(name, albedo):
    material = bpy.data.materials.new(name)
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*albedo, 1.0)
    shader.inputs["Roughness"].default_value = 0.0
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def to_blender(v):
    return (v[0], -v[2], v[1])


if __name__ == "__main__":
    main()
