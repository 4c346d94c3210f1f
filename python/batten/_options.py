"""What the functions share: no part of the interface."""

import os

from . import _errors


def mesh_of(V, F):
    """A Mesh as it is, or one of positions and triangles."""
    from ._meshes import Mesh

    if F is None:
        if isinstance(V, Mesh):
            return V
        raise _errors.InvalidInput(
            "give positions and triangles, or one Mesh, got " + type(V).__name__ + " alone"
        )
    if isinstance(V, Mesh):
        raise _errors.InvalidInput("a Mesh has its triangles; give none beside it")
    return Mesh(V, F)


def shape_of(shape):
    """A Mesh or a Network as it is, or a Mesh of a pair (positions, triangles)."""
    from ._meshes import Mesh

    if isinstance(shape, (tuple, list)) and len(shape) == 2:
        return Mesh(*shape)
    return shape


def path_of(path):
    """A path as text."""
    try:
        return os.fsdecode(path)
    except TypeError:
        raise _errors.InvalidInput("a path must be text or a path object, got " + repr(path)) from None

