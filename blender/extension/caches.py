"""Caches in Blender: where they are kept, and the modifier that shows them."""

import os
import shutil
import tempfile
import uuid
from pathlib import Path

import bpy
from bpy.app.handlers import persistent

from . import files
from .refused import Refused

NAME = "Taffeta"
# What is made of the shape of cloth, and so comes after it.
AFTER = {
    "BEVEL", "BUILD", "CORRECTIVE_SMOOTH", "DECIMATE", "EDGE_SPLIT", "LAPLACIANSMOOTH", "MULTIRES", "NODES", "NORMAL_EDIT",
    "PARTICLE_SYSTEM", "REMESH", "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "VOLUME_TO_MESH", "WEIGHTED_NORMAL", "WIREFRAME",
}  # fmt: skip

# Caches of a file that was never saved are those of this opening of it alone.
session = uuid.uuid4().hex


def modifier_of(one):
    """The object's modifier, if it has one."""
    modifier = one.modifiers.get(one.taffeta.modifier or NAME)
    return modifier if modifier is not None and modifier.type == "MESH_CACHE" else None


def place(one):
    """Where the cache is in the stack of modifiers, or would be: before the first that is made of the shape of cloth."""
    modifiers = list(one.modifiers)
    modifier = modifier_of(one)
    if modifier is not None:
        return modifiers.index(modifier)
    return next((index for index, other in enumerate(modifiers) if other.type in AFTER), len(modifiers))


def show(one, path, first):
    """Has the object show a cache from the frame `first` on."""
    modifier = modifier_of(one)
    if modifier is None:
        index = place(one)
        modifier = one.modifiers.new(NAME, "MESH_CACHE")
        # What is pinned to the end of the stack is still after a new one.
        one.modifiers.move(list(one.modifiers).index(modifier), index)
        one.taffeta.modifier = modifier.name
    modifier.cache_format = "PC2"
    modifier.frame_start = first
    modifier.filepath = short(path)
    refresh(one)


def short(path):
    """A path as the file keeps it: relative to the blend file, if there is one on the same drive."""
    if bpy.data.filepath:
        try:
            return bpy.path.relpath(str(path))
        except ValueError:
            pass
    return str(path)


def refresh(one):
    """Has the modifier read its file again."""
    one.update_tag()
    if one.data:
        one.data.update_tag()


def hide(one):
    """Removes the modifier."""
    modifier = modifier_of(one)
    if modifier is not None:
        one.modifiers.remove(modifier)
    one.taffeta.modifier = ""


def file_of(one):
    """The file that the object's modifier reads."""
    modifier = modifier_of(one) if one.type == "MESH" else None
    return Path(bpy.path.abspath(modifier.filepath)) if modifier is not None and modifier.filepath else None


def frames_of(one):
    """How many frames after the first the object's cache has, or None without one."""
    path = file_of(one)
    try:
        with open(path, "rb") as file:
            found = files.read_header(file.read(files.HEADER.size))
    except (OSError, TypeError):
        return None
    return found[1] - 1 if found else None


def unsaved():
    """Where caches of this file are kept before it is saved."""
    try:
        kept = bpy.utils.extension_path_user(__package__, path="cache", create=True)
    except ValueError:
        # It is no extension, as where its sources are tried.
        kept = tempfile.gettempdir()
    return Path(kept) / session


def folder_of(scene, filepath=None):
    """Where a scene's cache is kept, in the file that is open, or in one that it is saved as."""
    blend, wish = filepath or bpy.data.filepath, scene.taffeta.folder
    name = files.plain_names([scene.name])[scene.name]
    if not blend:
        if wish.startswith("//"):
            raise Refused(f"the cache is to be kept in {wish}, beside a file that is not saved yet; save it first, or choose another folder")
        return (Path(wish) if wish else unsaved()) / name
    blend = Path(blend)
    beside = Path(bpy.path.abspath(wish, start=str(blend.parent))) if wish else blend.parent
    return beside / f"taffeta_{blend.stem}" / name


@persistent
def forget_session(*_):
    """Another file was opened."""
    global session
    session = uuid.uuid4().hex
    for scene in bpy.data.scenes:
        scene.taffeta.said = ""
    for one in bpy.data.objects:
        if one.type == "MESH" and one.taffeta.role != "NONE" and one.taffeta.said and one.is_editable:
            one.taffeta.said = ""


@persistent
def bring_along(filepath, *_):
    """Moves caches beside a file that is saved for the first time."""
    here = unsaved()
    if bpy.data.filepath or not filepath or not here.exists():
        return
    for scene in bpy.data.scenes:
        source, target = here / files.plain_names([scene.name])[scene.name], folder_of(scene, filepath)
        if not source.exists() or scene.taffeta.folder:
            continue
        try:
            shutil.rmtree(target, ignore_errors=True)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(source, target)
        except OSError as error:
            print(f"Taffeta: the cache stays in {source}: {error}")
            continue
        for one in scene.objects:
            path = file_of(one)
            if path is not None and path.parent == source:
                # Relative to the file that is being saved.
                modifier_of(one).filepath = "//" + os.path.relpath(target / path.name, Path(filepath).parent).replace(os.sep, "/")


def register():
    bpy.app.handlers.load_post.append(forget_session)
    bpy.app.handlers.save_pre.append(bring_along)


def unregister():
    bpy.app.handlers.save_pre.remove(bring_along)
    bpy.app.handlers.load_post.remove(forget_session)
