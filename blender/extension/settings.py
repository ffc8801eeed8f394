"""What an object and a scene are set to. Lengths are millimetres where a number is said to be, whatever the unit of the scene."""

from functools import cache

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

ROLES = (
    ("NONE", "Nothing", "Taffeta leaves the object alone"),
    ("CLOTH", "Cloth", "A surface of fabric"),
    ("SOFT", "Soft body", "A closed mesh with an inside"),
    ("COLLIDER", "Collider", "What cloth and soft bodies rest on; it may be animated and deformed"),
)
VOLUMES = (
    ("KEEP", "Keep", "Keeps a volume, relative to that at the start"),
    ("PRESSURE", "Pressure", "Has a pressure inside, as a balloon"),
    ("NONE", "Nothing", "Springs alone keep the shape"),
)
DEVICES = (
    ("auto", "Automatic", "A graphics card where the scene gains by it, else the processor"),
    ("cpu", "Processor", "The processor: the same result on any machine"),
    ("gpu", "Graphics card", "The graphics card, through Vulkan, Metal or DirectX 12"),
)
CUSTOM = "custom"
# Files keep a fabric by its number, so that fabrics may be added: no number is ever given again.
NUMBERS = {
    CUSTOM: 0, "cotton": 1, "silk": 2, "wool": 3, "linen": 4, "denim": 5, "jersey": 6, "ponte": 7, "rib": 8, "polyester": 9, "blanket": 10,
}  # fmt: skip
# A path may begin with //, and newer versions want to be told so.
RELATIVE = {"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5) else set()
# What an object is set to can be overridden where it is linked from another file.
KEPT = {"options": set(), "override": {"LIBRARY_OVERRIDABLE"}}


@cache
def fabrics():
    """The fabrics by name, as taffeta has them."""
    import taffeta

    return taffeta.materials()


@cache
def _fabric_items():
    # Blender keeps no reference to the strings of a list that a function returns.
    items = [(name, name.capitalize(), fabric["title"], "NONE", NUMBERS[name]) for name, fabric in fabrics().items()]
    return [*items, (CUSTOM, "Custom", "Numbers of your own", "NONE", NUMBERS[CUSTOM])]


class TaffetaObject(bpy.types.PropertyGroup):
    role: EnumProperty(name="Role", items=ROLES, default="NONE", **KEPT)

    fabric: EnumProperty(name="Fabric", items=lambda _self, _context: _fabric_items(), default=NUMBERS["cotton"], **KEPT)
    density: FloatProperty(name="Density (kg/m²)", default=0.15, min=0.001, max=100, precision=3, **KEPT)
    stretch: FloatVectorProperty(
        name="Stretch (N/m)", size=2, default=(2500, 1500), min=0.1, max=1e7, **KEPT,
        description="Stiffness along the warp and the weft: U and V of the UV map",
    )
    shear: FloatProperty(name="Shear (N/m)", default=60, min=0.01, max=1e7, **KEPT)
    bending: FloatVectorProperty(
        name="Bending (µN·m)", size=2, default=(16, 10), min=0, max=1e9, **KEPT,
        description="Rigidity along the warp and the weft",
    )

    keeps_bends: BoolProperty(
        name="Keeps Its Bends", default=True, **KEPT,
        description="The fabric is at rest with the bends that were modelled. Without it, it wants to be flat, as woven cloth does",
    )

    thickness: FloatProperty(
        name="Thickness (mm)", default=3, min=0.01, max=1000, precision=2, **KEPT,
        description="Distance that is kept: of cloth from itself and other cloth, of a collider from all that rests on it",
    )
    friction: FloatProperty(
        name="Friction", default=0.3, min=0, max=10, **KEPT,
        description="Coulomb's coefficient; between two objects the geometric mean of both",
    )
    self_contact: BoolProperty(
        name="Touches Itself", default=True, **KEPT,
        description="Folds never pass through each other. Without it cloth still touches other objects",
    )

    pin_group: StringProperty(
        name="Pinned", **KEPT,
        description="Vertex group: full weights are held, or follow their armature; smaller ones are pulled by springs",
    )
    pin_stiffness: FloatProperty(
        name="Pull (N/m)", default=20, min=1e-3, max=1e7, **KEPT,
        description="Spring of a vertex with a weight of nearly 1 in the group; others have it by their weight",
    )
    tethers: BoolProperty(
        name="Tethers", default=False, **KEPT,
        description="No vertex gets farther from the pinned ones than along the surface, so cloth hardly stretches as it hangs",
    )
    sewing: BoolProperty(
        name="Sewing", default=False, **KEPT,
        description="Edges without faces pull their ends together",
    )
    sewing_time: FloatProperty(
        name="Closes in (s)", default=0.5, min=0, max=1000, **KEPT, description="Time in which seams close"
    )
    rest_key: StringProperty(
        name="Rest Shape", **KEPT,
        description="Shape key with the lengths at rest, such as a flat pattern. Empty: the shape at the start",
    )

    mass: FloatProperty(name="Mass (kg)", default=1, min=1e-6, max=1e6, **KEPT)
    stiffness: FloatProperty(
        name="Stiffness", default=1, min=1e-3, max=1e3, **KEPT,
        description="1 is foam that keeps its shape; 0.1 is a jelly, 10 is firm rubber",
    )
    volume: EnumProperty(name="Volume", items=VOLUMES, default="KEEP", **KEPT)
    volume_target: FloatProperty(
        name="Volume", default=1, min=0.01, max=100, **KEPT, description="Relative to that at the start"
    )
    pressure: FloatProperty(name="Pressure (Pa)", default=100, min=-1e6, max=1e6, **KEPT)

    modifier: StringProperty(options={"HIDDEN"}, override={"LIBRARY_OVERRIDABLE"}, description="The modifier that shows the cache")
    said: StringProperty(options={"SKIP_SAVE", "HIDDEN"}, description="What the last bake said of the object, by lines")


class TaffetaScene(bpy.types.PropertyGroup):
    steps: IntProperty(
        name="Steps", default=10, min=1, max=1000, options=set(),
        description="Steps in a frame. More are finer in time, and take longer; ten are good at 24 frames a second",
    )
    device: EnumProperty(name="Device", items=DEVICES, default="cpu", options=set())
    air: BoolProperty(
        name="Air", default=True, options=set(), description="Cloth feels the air: drag, and the scene's wind force fields"
    )
    folder: StringProperty(
        name="Cache", subtype="DIR_PATH", options=RELATIVE,
        description="Where frames are kept, in a folder of the file's name. Empty: beside the blend file",
    )
    baked: StringProperty(options={"HIDDEN"}, description="Settings that the cache was made with")
    said: StringProperty(options={"SKIP_SAVE", "HIDDEN"}, description="What the last bake said, by lines")


def shown(group):
    """The settings of a group as they are shown: what changes none of them changes no frame."""
    hidden = {"said", "baked", "folder", "modifier"}
    values = {}
    for name, kind in group.bl_rna.properties.items():
        if name not in hidden and not kind.is_readonly and name != "name":
            value = getattr(group, name)
            values[name] = list(value) if getattr(kind, "is_array", False) else value
    return values


CLASSES = (TaffetaObject, TaffetaScene)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Object.taffeta = PointerProperty(type=TaffetaObject, override={"LIBRARY_OVERRIDABLE"})
    bpy.types.Scene.taffeta = PointerProperty(type=TaffetaScene)


def unregister():
    del bpy.types.Scene.taffeta
    del bpy.types.Object.taffeta
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
