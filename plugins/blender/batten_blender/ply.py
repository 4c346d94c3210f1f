"""Meshes between arrays and the binary PLY files of the program: doubles, triangles, values per face."""

import numpy as np

TYPES = {
    "char": "i1", "uchar": "u1", "short": "<i2", "ushort": "<u2", "int": "<i4", "uint": "<u4", "float": "<f4", "double": "<f8",
}


def write(path, V, F, face_values=None):
    """Vertices V (n x 3) and triangles F (m x 3), with values per face: names to m whole numbers."""
    face_values = face_values or {}
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(V)}"]
    header += [f"property double {axis}" for axis in "xyz"]
    header += [f"element face {len(F)}", "property list uchar int vertex_indices"]
    header += [f"property int {name}" for name in face_values]
    faces = np.empty(len(F), [("count", "u1"), ("corners", "<i4", 3)] + [(name, "<i4") for name in face_values])
    faces["count"] = 3
    faces["corners"] = F
    for name, values in face_values.items():
        faces[name] = values
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\nend_header\n").encode())
        file.write(np.ascontiguousarray(V, "<f8").tobytes())
        file.write(faces.tobytes())


def read(path):
    """V (n x 3), F (m x 3), values per vertex and per face, both as names to arrays, of a file that the program wrote."""
    with open(path, "rb") as file:
        content = file.read()
    end = content.index(b"end_header\n") + len(b"end_header\n")
    counts, fields = {}, {}
    for line in content[:end].decode().splitlines():
        words = line.split()
        if words[0] == "element":
            element = words[1]
            counts[element], fields[element] = int(words[2]), []
        elif words[:2] == ["property", "list"]:
            # The program writes triangles alone: the lists of all faces are of one length.
            fields[element] += [("count", TYPES[words[2]]), ("corners", TYPES[words[3]], 3)]
        elif words[0] == "property":
            fields[element].append((words[2], TYPES[words[1]]))
    vertices = np.frombuffer(content, fields["vertex"], counts["vertex"], end)
    faces = np.frombuffer(content, fields["face"], counts["face"], end + vertices.nbytes)
    V = np.stack([vertices[axis] for axis in "xyz"], axis=1)
    vertex_values = {name: vertices[name] for name in vertices.dtype.names if name not in "xyz"}
    face_values = {name: faces[name] for name in faces.dtype.names if name not in ("count", "corners")}
    return V, faces["corners"], vertex_values, face_values
