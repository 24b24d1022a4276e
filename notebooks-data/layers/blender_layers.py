# SPDX-License-Identifier: Apache-2.0
"""Renders the layers that `mtf render --from` takes, with Blender (3.4 and later), of the scene of a .blend file:

  blender -b scene.blend -P blender_layers.py -- layers.exr --columns 512 --rows 320 --pitch 24 --focal-length 120

Pitch in um, focal length in mm, as in [frame] of the sensor file; --samples-per-pitch is that of the picture (default 2). The camera of
the scene keeps its place. Each material needs a Pass Index (Properties, Material, Settings) other than 0, which the table
--materials names; a material with a node "AOV Output" of the name "temperature" gives kelvin. Prints the command that goes on.
"""

import argparse
import sys

import bpy
from mathutils import Vector


def main():
    parser = argparse.ArgumentParser(prog="blender_layers.py")
    parser.add_argument("out")
    parser.add_argument("--columns", type=int, required=True)
    parser.add_argument("--rows", type=int, required=True)
    parser.add_argument("--pitch", type=float, required=True, help="um")
    parser.add_argument("--focal-length", type=float, required=True, help="mm")
    parser.add_argument("--samples-per-pitch", type=float, default=2.0)
    a = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else ["--help"])

    scene = bpy.context.scene
    camera = scene.camera.data
    camera.type, camera.sensor_fit = "PERSP", "HORIZONTAL"
    camera.sensor_width, camera.lens = 1e-3 * a.pitch * a.columns, a.focal_length
    camera.shift_x = camera.shift_y = 0.0
    camera.clip_end = 1e6
    camera.dof.use_dof = False

    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x = round(a.columns * a.samples_per_pitch)
    render.resolution_y = round(a.rows * a.samples_per_pitch)
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    # One ray through the middle of each sample: means of indices, normals and depths over a pixel are those of nothing.
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BLACKMAN_HARRIS", 0.01

    render.use_motion_blur = render.use_border = render.use_sequencer = False

    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_material_index = layer.use_pass_normal = True
    if any(has_temperature(m) for m in bpy.data.materials) and "temperature" not in layer.aovs:
        aov = layer.aovs.add()
        aov.name, aov.type = "temperature", "VALUE"

    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    render.filepath = a.out
    bpy.ops.render.render(write_still=True)

    turn = scene.camera.matrix_world.to_3x3()
    if abs((turn @ Vector((1.0, 0.0, 0.0))).z) > 1e-6:
        print("The camera is rolled: write up = [%.9g, %.9g, %.9g] into [camera]" % tuple(turn @ Vector((0.0, 1.0, 0.0))))
    place = scene.camera.matrix_world.translation
    ahead = place + 100.0 * (turn @ Vector((0.0, 0.0, -1.0)))
    words = [",".join(f"{x:.9g}" for x in v) for v in (place, ahead)]
    print(f"mtf render scene.toml sensor.toml --from {a.out} --materials materials.csv"
          f" --position={words[0]} --look-at={words[1]} -o picture.exr")


def has_temperature(material):
    nodes = material.node_tree.nodes if material.use_nodes else []
    # Blender 4.2 and later keep the name of the pass apart from that of the node.
    return any(node.type == "OUTPUT_AOV" and getattr(node, "aov_name", node.name) == "temperature" for node in nodes)


main()
