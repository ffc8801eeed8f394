"""Small tables for notebooks. They load nothing from elsewhere."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from taffeta._native import Simulation


def table(title: str, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A title and a table."""
    cells = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<div><b>{escape(title)}</b><table><tr>{cells}</tr>{body}</table></div>"


def of_simulation(simulation: Simulation) -> str:
    """The bodies of a simulation, and where it is."""
    title = f"frame {simulation.frame}, {simulation.time:.3f} s, {simulation.device}, {simulation.precision}"
    rows = [
        (body.name, body.vertices, body.triangles, body.springs, body.pinned, f"{body.mass:.4g}")
        for body in simulation.bodies.values()
    ]
    return table(title, ("body", "vertices", "triangles", "springs", "pinned", "mass [kg]"), rows)


def of_scene(title: str, document: dict[str, Any]) -> str:
    """The bodies and colliders of a scene."""
    rows = [_body(index, body) for index, body in enumerate(document.get("body", []))]
    rows += [_collider(index, one) for index, one in enumerate(document.get("collider", []))]
    return table(title, ("name", "what", "of"), rows)


def _body(index: int, body: dict[str, Any]) -> tuple[str, str, str]:
    material: Any = body.get("material")
    fabric = "springs" if material is None else material.get("preset", "fabric")
    shape = _shape(body["mesh"])
    return body.get("name", f"body{index}"), body.get("kind", "cloth"), f"{shape}, {fabric}"


def _collider(index: int, collider: dict[str, Any]) -> tuple[str, str, str]:
    shapes = ("sphere", "plane", "box", "capsule", "cylinder", "mesh", "convex", "heightfield")
    shape = next((shape for shape in shapes if shape in collider), "")
    return collider.get("name", f"collider{index}"), "collider", shape


def _shape(mesh: Any) -> str:
    """The key of a shape; a mesh of arrays may be any object."""
    keys = list(cast("Mapping[str, Any]", mesh)) if isinstance(mesh, Mapping) else ["vertices"]
    return "arrays" if "vertices" in keys or not keys else keys[0]
