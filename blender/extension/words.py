"""What the engine says, in words of Blender: objects by their names, and nothing of scene files."""

import re

from . import describe

PLACE = re.compile(r"^.*?\.toml(?::\d+)*: (?:`(?P<list>\w+)\[(?P<index>\d+)\](?P<key>[^`]*)`: )?", re.DOTALL)
# Advice in words of scene files, at the end.
ADVICE = re.compile(r" \((?:[^()]|\([^()]*\))* = (?:[^()]|\([^()]*\))*\)$")


class Words:
    """Names of objects, and what scenes call them."""

    def __init__(self, names):
        """`names` has for each object, by its full name, what a scene calls it."""
        self.names = names
        self.order = {"body": [], "collider": []}

    def of_blender(self, text):
        """The text, and the objects that it is about."""
        found, about = PLACE.match(text), []
        if found:
            text = text[found.end() :]
            listed = self.order.get(found["list"], [])
            if found["index"] and int(found["index"]) < len(listed):
                about.append(listed[int(found["index"])])
                # What is left of a place in a scene file says little; numbers of vertices are in the text.
                key = found["key"].lstrip(".").partition(".")[0]
                text = text if key in ("", "mesh", "pin") else f"{key}: {text}"
        text = ADVICE.sub("", text)
        for name, plain in self.names.items():
            called = re.compile(f"(?:body |collider )?`{re.escape(plain)}(?:{describe.PULLING})?`")
            if called.search(text):
                about.append(name)
                text = called.sub(lambda _, name=name: f"`{name}`", text)
        return text, list(dict.fromkeys(about))
