"""The example of the guide, for some frames."""

from pathlib import Path

import bpy


def test_the_dancer_is_dressed(world):
    source = Path(__file__).parents[2] / "examples/blender/dancer.py"
    text = source.read_text("utf-8").replace("FRAMES = 96", "FRAMES = 4")
    exec(compile(text, str(source), "exec"), {"__name__": "__main__"})
    bpy.ops.taffeta.bake()
    scene = bpy.context.scene
    assert scene.name == "dancer" and scene.taffeta.said == ""
    for name in ("figure", "skirt", "cape"):
        assert scene.objects[name].taffeta.said == "", name
    hem = [world.at(scene.objects["skirt"], frame)[:, 2].min() for frame in (1, 4)]
    # In an eighth of a second its hem has begun to swing.
    assert abs(hem[1] - hem[0]) > 1e-3, hem
