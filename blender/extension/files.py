"""Files of a bake: meshes as OBJ, frames as PC2 (3ds Max's point cache, which Mesh Cache modifiers read)."""

import itertools
import re
import struct

import numpy as np

HEADER = struct.Struct("<12siiffi")


def header(points, samples):
    return HEADER.pack(b"POINTCACHE2\0", 1, points, 0.0, 1.0, samples)


def read_header(data):
    """Numbers of points and of samples, or None where it is no PC2 file."""
    if len(data) < HEADER.size:
        return None
    magic, version, points, _, _, samples = HEADER.unpack(data[: HEADER.size])
    return (points, samples) if magic == b"POINTCACHE2\0" and version == 1 else None


class Poses:
    """Samples of a mesh, in a file from the first that differs on: most things do not move."""

    def __init__(self, path):
        self.path, self.first, self.count, self.file = path, None, 0, None

    def add(self, points):
        points = np.ascontiguousarray(points, "<f4")
        if self.first is None:
            self.first = points
        elif self.file is None and not np.array_equal(points, self.first):
            self.file = open(self.path, "wb")
            self.file.write(header(len(points), 0))
            for _ in range(self.count):
                self.file.write(self.first.tobytes())
        if self.file is not None:
            self.file.write(points.tobytes())
        self.count += 1

    def close(self):
        """Whether there is a file: whether anything moves."""
        if self.file is None:
            return False
        self.file.seek(0)
        self.file.write(header(len(self.first), self.count))
        self.file.close()
        return True


def write_obj(path, points, faces, uvs=None):
    """A mesh of points [n, 3], faces as lists of points, and texture coordinates of all corners [corners, 2], if it has some."""
    lines = ["v %.9g %.9g %.9g" % tuple(point) for point in np.asarray(points, np.float32).tolist()]
    if uvs is None:
        lines += ["f " + " ".join([str(vertex + 1) for vertex in face]) for face in faces]
    else:
        lines += ["vt %.9g %.9g" % tuple(uv) for uv in np.asarray(uvs, np.float32).tolist()]
        corners = itertools.count(1)
        lines += ["f " + " ".join([f"{vertex + 1}/{next(corners)}" for vertex in face]) for face in faces]
    path.write_text("\n".join(lines) + "\n", "utf-8")


def plain_names(names):
    """For each name of an object one of letters, digits and _, for the scene and for files; no two are the same, in capitals or not.
    What is made of one has a - or a . in its name, and so is no other's."""
    plain, used = {}, set()
    for name in names:
        word = re.sub(r"\W+", "_", name).strip("_")[:40] or "object"
        number, free = 2, word
        while free.lower() in used:
            free, number = f"{word}_{number}", number + 1
        used.add(free.lower())
        plain[name] = free
    return plain
