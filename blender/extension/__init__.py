"""Taffeta in Blender: cloth and soft bodies in a background process, their frames in a Mesh Cache modifier.

What an object is, and what of, is a setting of the object (`settings`). A bake samples the animation (`sample`), writes a scene of
taffeta's own format (`describe`), has a process of its own run it (`job`, `worker`), and shows its frames (`caches`).
"""

from . import bake, caches, exchange, objects, panels, settings

PARTS = (settings, caches, objects, bake, exchange, panels)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()
