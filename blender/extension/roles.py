"""Which objects take part in what."""

from . import settings

NAMES = {name: shown for name, shown, _ in settings.ROLES}


def simulated(scene, *roles):
    """Objects of a scene in some roles, by name."""
    roles = roles or ("CLOTH", "SOFT", "COLLIDER")
    # Objects of one name may come from different files, and have names of their own in full.
    return sorted((one for one in scene.objects if one.type == "MESH" and one.taffeta.role in roles), key=lambda one: one.name_full)


def find(scene, name):
    """The object of a full name."""
    return next((one for one in scene.objects if one.name_full == name), None)
