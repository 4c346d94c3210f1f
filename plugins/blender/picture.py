"""Draws docs/pictures/blender-sphere.png: three circles, and the surface that the add-on fills them with.

blender -b --factory-startup --python plugins/blender/picture.py -- ADDON.zip PROGRAM PICTURE.png
"""

import math
import sys

import bpy
from mathutils import Vector

ADDON, PROGRAM, PICTURE = sys.argv[sys.argv.index("--") + 1 :]


def material(name, colour, roughness):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    shader.inputs["Roughness"].default_value = roughness
    return made


def three_circles(x, bevel):
    made = []
    for rotation in ((0, 0, 0.3), (math.pi / 2, 0, 0.3), (math.pi / 2, 0, 0.3 + math.pi / 2)):
        bpy.ops.curve.primitive_bezier_circle_add(radius=1, location=(x, 0, 1.03), rotation=rotation)
        circle = bpy.context.object
        circle.data.resolution_u = 32
        circle.data.bevel_depth = bevel
        circle.data.materials.append(ink)
        made.append(circle)
    return made


bpy.ops.preferences.addon_install(filepath=ADDON)
bpy.ops.preferences.addon_enable(module="batten_blender")
bpy.context.preferences.addons["batten_blender"].preferences.program = PROGRAM

scene = bpy.context.scene
for obj in list(bpy.data.objects):
    bpy.data.objects.remove(obj)
ink, paint = material("Ink", (0.02, 0.05, 0.2), 0.5), material("Paint", (0.8, 0.35, 0.12), 0.15)
three_circles(-1.25, 0.02)
for circle in three_circles(1.25, 0.012):
    circle.select_set(True)
for circle in bpy.data.objects:
    circle.select_set(circle.location.x > 0)
bpy.ops.batten.surface()
surface = bpy.context.object
surface.data.materials.clear()
surface.data.materials.append(paint)

bpy.ops.mesh.primitive_plane_add(size=200)
bpy.context.object.data.materials.append(material("Floor", (0.8, 0.8, 0.8), 0.9))
for location, energy, size in (((-3, -4, 6), 500, 3), ((5, -2, 3), 120, 2)):
    bpy.ops.object.light_add(type="AREA", location=location)
    light = bpy.context.object
    light.data.energy, light.data.size = energy, size
    light.rotation_euler = (Vector((0, 0, 1)) - light.location).to_track_quat("-Z", "Y").to_euler()
bpy.ops.object.camera_add(location=(0, -8, 3.2))
scene.camera = bpy.context.object
scene.camera.rotation_euler = (Vector((0, 0, 0.95)) - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
scene.camera.data.lens = 50

scene.render.engine = "CYCLES"
scene.cycles.samples = 16
scene.cycles.use_denoising = False
scene.render.resolution_x, scene.render.resolution_y = 720, 360
scene.render.filepath = PICTURE
bpy.ops.render.render(write_still=True)
