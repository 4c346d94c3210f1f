"""Batten turns curves traced on an object into a fair surface, and processes meshes.

Functions take arrays (anything that numpy makes one of) and give arrays in small objects; everything after the arrays is
given by keyword, under the names and with the defaults of the command line. Ctrl-C stops every function; the lock of the
interpreter is free while they work. See docs/python.md.
"""

from ._batten import __version__
from ._errors import Cancelled, Error, FileError, InvalidInput, SolverFailure
from ._files import (
    read_cage,
    read_mesh,
    read_network,
    read_rawnet,
    read_scan,
    read_sensor_log,
    write_cage,
    write_mesh,
    write_network,
    write_rawnet,
    write_sensor_log,
)
from ._meshes import (
    Cage,
    Comparison,
    CurveCheck,
    Mesh,
    Subdivision,
    Surface,
    carry_values,
    check,
    compare,
    deform,
    fair,
    remesh,
    repair,
    simplify,
    subdivide,
)
from ._networks import (
    Network,
    Scan,
    ScanCurve,
    SensorLog,
    Simulation,
    infer_nodes,
    network_from_scan,
    reconstruct,
    simulate,
    surface,
)
from ._solvers import ReconstructionSolver, SurfaceSolver
from ._threads import set_threads, threads

__all__ = [
    "Cage",
    "Cancelled",
    "Comparison",
    "CurveCheck",
    "Error",
    "FileError",
    "InvalidInput",
    "Mesh",
    "Network",
    "ReconstructionSolver",
    "Scan",
    "ScanCurve",
    "SensorLog",
    "Simulation",
    "SolverFailure",
    "Subdivision",
    "Surface",
    "SurfaceSolver",
    "__version__",
    "carry_values",
    "check",
    "compare",
    "deform",
    "fair",
    "infer_nodes",
    "network_from_scan",
    "read_cage",
    "read_mesh",
    "read_network",
    "read_rawnet",
    "read_scan",
    "read_sensor_log",
    "reconstruct",
    "remesh",
    "repair",
    "set_threads",
    "simplify",
    "simulate",
    "subdivide",
    "surface",
    "threads",
    "write_cage",
    "write_mesh",
    "write_network",
    "write_rawnet",
    "write_sensor_log",
]

for _name in __all__:  # messages and pickles name what users import
    if _name[0] != "_":
        globals()[_name].__module__ = __name__
del _name
