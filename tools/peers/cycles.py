#!/usr/bin/env python3
"""Renders a .glb file with Cycles and compares the picture with ours.

    python3.11 -m pip install "bpy==4.5.*" mitsuba numpy pillow
    python3.11 tools/peers/cycles.py SCENE.glb --ours OURS.exr [--camera N] [--size WxH] [--spp N] [-o STEM]

See README.md here for what is undone of Blender's importer, and why.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from gltf import EFFECTS, Gltf, intensity_scale
import pictures

import bpy
import numpy as np
from mathutils import Matrix

KEEPABLE = {
    "spots": "Blender's profile of spot lights in place of glTF's",
    "sun": "the sun's diameter of 0.526 degrees",
    "absorption": "absorption by (1 - colour) / distance in place of -ln(colour) / distance",
    "multiscatter": "multiple scattering among the microfacets of metals",
    "texels": "interpolation of texels before they are made linear",
    "bump": "softening of the edge of shadows that normal maps make",
}
# glTF's +y is Blender's +z.
UPRIGHT = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))


def set_camera(gltf, number, size):
    """Made from the file: the importer renames cameras, and fits the field of view to an aspect ratio that is not ours."""
    matrix, yfov = gltf.camera(number)
    data = bpy.data.cameras.new("peer")
    data.sensor_fit = "VERTICAL"
    data.angle_y = yfov
    data.clip_start, data.clip_end = 1e-3, 1e5
    camera = bpy.data.objects.new("peer", data)
    camera.matrix_world = UPRIGHT @ Matrix(matrix.tolist())
    bpy.context.collection.objects.link(camera)
    scene = bpy.context.scene
    scene.camera = camera
    render = scene.render
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1


def set_integrator(samples, threads, edges):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.threads_mode, scene.render.threads = "FIXED", threads
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.use_motion_blur = False
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    scene.view_settings.view_transform = "Standard"
    world = bpy.data.worlds.new("black")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.world = world
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_guiding = False
    cycles.time_limit = 0
    # No bounce is a path of two edges.
    for name in ["max", "diffuse", "glossy", "transmission", "volume"]:
        setattr(cycles, f"{name}_bounces", edges - 2)
    cycles.transparent_max_bounces = 1024
    cycles.min_light_bounces = cycles.min_transparent_bounces = 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_fast_gi = False
    cycles.film_exposure = 1
    cycles.pixel_filter_type = "BOX"


def nodes_of(kind):
    for material in bpy.data.materials:
        if material.node_tree:
            for node in material.node_tree.nodes:
                if node.bl_idname == kind:
                    yield material, node


def profile_by_nodes(lamp, light, axis):
    """glTF's angular attenuation on a point light, whose own is none."""
    spot = light.get("spot", {})
    inner, outer = math.cos(spot.get("innerConeAngle", 0)), math.cos(spot.get("outerConeAngle", math.pi / 4))
    lamp.use_nodes = True
    tree = lamp.node_tree
    new, link = tree.nodes.new, tree.links.new
    geometry, dot = new("ShaderNodeNewGeometry"), new("ShaderNodeVectorMath")
    dot.operation = "DOT_PRODUCT"
    # Incoming is from the light to what it lights.
    dot.inputs[1].default_value = axis
    link(geometry.outputs["Incoming"], dot.inputs[0])
    ramp = new("ShaderNodeMapRange")
    ramp.clamp = True
    ramp.inputs["From Min"].default_value, ramp.inputs["From Max"].default_value = outer, max(inner, outer + 1e-6)
    link(dot.outputs["Value"], ramp.inputs["Value"])
    square = new("ShaderNodeMath")
    square.operation = "POWER"
    square.inputs[1].default_value = 2
    link(ramp.outputs["Result"], square.inputs[0])
    link(square.outputs["Value"], tree.nodes["Emission"].inputs["Strength"])


def set_lights(gltf, units, keep):
    """Made from the file, because the importer renames lights that share a name. A light's axis is -z in both."""
    for object in [o for o in bpy.data.objects if o.type == "LIGHT"]:
        bpy.data.objects.remove(object)
    pointlike, parallel = intensity_scale(units)
    for light, matrix in gltf.lights():
        kind, own = light["type"], "spots" in keep
        blenders = {"directional": "SUN", "point": "POINT", "spot": "SPOT" if own else "POINT"}[kind]
        lamp = bpy.data.lights.new("peer", blenders)
        lamp.color = light.get("color", [1, 1, 1])
        lamp.shadow_soft_size = 0
        strength = light.get("intensity", 1)
        matrix = UPRIGHT @ Matrix(matrix.tolist())
        if kind == "directional":
            lamp.energy = strength * parallel
            if "sun" not in keep:
                lamp.angle = 0
        else:
            lamp.energy = strength * pointlike * 4 * math.pi
        if kind == "spot" and own:
            spot = light.get("spot", {})
            outer = spot.get("outerConeAngle", math.pi / 4)
            lamp.spot_size, lamp.spot_blend = 2 * outer, 1 - spot.get("innerConeAngle", 0) / outer
        elif kind == "spot":
            profile_by_nodes(lamp, light, -matrix.to_3x3().col[2].normalized())
        object = bpy.data.objects.new("peer", lamp)
        object.matrix_world = matrix
        bpy.context.collection.objects.link(object)


def set_materials(gltf, keep):
    described = {material.get("name"): material for material in gltf.json.get("materials", [])}
    for material, node in nodes_of("ShaderNodeVolumeAbsorption"):
        volume = described[material.name]["extensions"]["KHR_materials_volume"]
        if "absorption" not in keep and "attenuationColor" in volume:
            sigma = -np.log(volume["attenuationColor"]) / volume["attenuationDistance"]
            density = float(sigma.max()) * 2
            node.inputs["Density"].default_value = density
            node.inputs["Color"].default_value = [*(1 - sigma / density), 1]
    for _, node in nodes_of("ShaderNodeBsdfPrincipled"):
        # Without multiple scattering, dielectrics take from their base what a layer with it would reflect, and are too dark.
        metal = node.inputs["Metallic"]
        if (metal.is_linked or metal.default_value > 0) and "multiscatter" not in keep:
            node.distribution = "GGX"
    linear = {}
    for _, node in nodes_of("ShaderNodeTexImage"):
        image = node.image
        if "texels" in keep or image is None or image.colorspace_settings.is_data or image.is_float:
            continue
        if image.name not in linear:
            pixels = np.array(image.pixels[:], dtype=np.float32).reshape(-1, 4)
            rgb = pixels[:, :3]
            pixels[:, :3] = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
            copy = bpy.data.images.new(image.name + " linear", *image.size, alpha=True, float_buffer=True)
            copy.colorspace_settings.is_data = True
            copy.alpha_mode = "CHANNEL_PACKED"
            copy.pixels.foreach_set(pixels.ravel())
            copy.update()
            copy.pack()
            linear[image.name] = copy
        node.image = linear[image.name]
    for material in bpy.data.materials:
        material.cycles.use_bump_map_correction = "bump" in keep
    for object in bpy.data.objects:
        object.shadow_terminator_geometry_offset = object.shadow_terminator_shading_offset = 0


def main():
    parser = argparse.ArgumentParser(description="Compares a picture of ours with Cycles.")
    parser.add_argument("scene", metavar="SCENE.glb")
    parser.add_argument("--ours", required=True, metavar="OURS.exr")
    parser.add_argument("--camera", type=int, default=0)
    parser.add_argument("--size", default="256x192", metavar="WxH")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--edges", type=int, default=16, help="our max_edges")
    parser.add_argument("--units", default="radiometric", choices=["radiometric", "photometric", "watts"], help="our light_units")
    parser.add_argument("--without", default="", help=", ".join(f"{k}: {v}" for k, v in EFFECTS.items()))
    parser.add_argument("--keep", default="", help=", ".join(f"{k}: {v}" for k, v in KEEPABLE.items()))
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--replicas", type=int, default=4)
    parser.add_argument("-o", "--output", metavar="STEM")
    options = parser.parse_args()
    size = tuple(int(x) for x in options.size.split("x"))
    keep = set(filter(None, options.keep.split(",")))
    if keep - KEEPABLE.keys():
        raise SystemExit(f"--keep {options.keep}: not all of them are of {', '.join(KEEPABLE)}")

    gltf = Gltf(options.scene)
    gltf.without(["animation", *filter(None, options.without.split(","))])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = str(Path(folder) / "scene.glb")
        gltf.write(copy)
        bpy.ops.import_scene.gltf(filepath=copy, export_import_convert_lighting_mode="RAW")
        set_integrator(max(options.spp // options.replicas, 1), options.threads, options.edges)
        set_camera(gltf, options.camera, size)
        bpy.context.view_layer.update()
        set_lights(gltf, options.units, keep)
        set_materials(gltf, keep)
        replicas = []
        for seed in range(options.replicas):
            bpy.context.scene.cycles.seed = seed
            bpy.context.scene.render.filepath = str(Path(folder) / f"{seed}.exr")
            bpy.ops.render.render(write_still=True)
            replicas.append(pictures.read(bpy.context.scene.render.filepath)[0])
    facts = {
        "peer": f"Cycles of Blender {bpy.app.version_string}",
        "scene": options.scene,
        "camera": options.camera,
        "spp": options.spp,
        "without": options.without,
        "keep": options.keep,
    }
    pictures.compare(options.ours, np.array(replicas), facts, options.output)


if __name__ == "__main__":
    main()
