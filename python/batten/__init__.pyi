import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Names, signatures and defaults; the docstrings are in the sources. A test holds this file against them.
# Arrays of a class are what they were made with until a function of the package makes them: hence Any.

__version__: str
__all__: list[str]

Path = Union[str, os.PathLike[str]]
Progress = Callable[[str, float], Any]

class Error(RuntimeError): ...
class InvalidInput(Error, ValueError): ...
class FileError(Error, OSError):
    path: str
    line: int | None
class SolverFailure(Error): ...
class Cancelled(Error): ...

class Mesh:
    positions: Any
    triangles: Any
    normals: Any
    values: dict[str, Any]
    name: str
    unit: str
    warnings: list[str]
    report: Any
    vertex_map: Any
    levels: list[Mesh]
    def __init__(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        normals: ArrayLike | None = None,
        values: Mapping[str, ArrayLike] | None = None,
        *,
        name: str = "mesh",
        unit: str = "",
    ) -> None: ...
    def __iter__(self) -> Iterator[Any]: ...

class Surface(Mesh):
    patch_of_triangle: Any
    network: Network
    def __init__(
        self,
        positions: ArrayLike,
        triangles: ArrayLike,
        normals: ArrayLike | None = None,
        values: Mapping[str, ArrayLike] | None = None,
        *,
        name: str = "surface",
        unit: str = "",
    ) -> None: ...
    @property
    def uncertainty(self) -> Any: ...

class Cage:
    positions: Any
    faces: Any
    sharp_edges: dict[tuple[int, int], float]
    sharp_vertices: dict[int, float]
    polylines: dict[tuple[int, int], Any]
    normals: Any
    warnings: list[str]
    def __init__(
        self,
        positions: ArrayLike,
        faces: Any,
        sharp_edges: Mapping[tuple[int, int], float] | None = None,
        sharp_vertices: Mapping[int, float] | None = None,
        polylines: Mapping[tuple[int, int], ArrayLike] | None = None,
        normals: ArrayLike | None = None,
    ) -> None: ...

class Subdivision(Cage):
    triangles: Any
    report: Any
    def __init__(
        self,
        positions: ArrayLike,
        faces: Any,
        sharp_edges: Mapping[tuple[int, int], float] | None = None,
        sharp_vertices: Mapping[int, float] | None = None,
        polylines: Mapping[tuple[int, int], ArrayLike] | None = None,
        normals: ArrayLike | None = None,
    ) -> None: ...
    def mesh(self) -> Mesh: ...

class CurveCheck:
    report: dict[str, Any]
    warnings: list[str]
    passes: bool
    curves: list[dict[str, Any]]
    def __init__(self, report: dict[str, Any]) -> None: ...

class Comparison:
    report: dict[str, Any]
    warnings: list[str]
    hausdorff: float
    distances: NDArray[np.float64]
    mesh: Any
    def __init__(self, report: dict[str, Any], hausdorff: float, distances: Any, mesh: Mesh | None) -> None: ...

class Network:
    positions: Any
    curves: list[Any]
    normals: Any
    boundary: Any
    names: Any
    sharp: Any
    left_normals: Any
    right_normals: Any
    nodes: Any
    unit: str
    uncertainty: Any
    warnings: list[str]
    report: Any
    def __init__(
        self,
        positions: ArrayLike,
        curves: Iterable[ArrayLike],
        normals: ArrayLike | None = None,
        boundary: Sequence[bool] | None = None,
        names: Sequence[str] | None = None,
        sharp: Sequence[bool] | None = None,
        left_normals: Sequence[ArrayLike | None] | None = None,
        right_normals: Sequence[ArrayLike | None] | None = None,
        nodes: ArrayLike = (),
        unit: str = "",
        uncertainty: ArrayLike | None = None,
    ) -> None: ...

class ScanCurve:
    distances: Any
    tangents: Any
    normals: Any
    node_readings: Any
    node_ids: Any
    boundary: bool
    closed: bool
    sharp: bool
    name: str
    turns: Any
    turn_times: Any
    def __init__(
        self,
        distances: ArrayLike,
        tangents: ArrayLike,
        normals: ArrayLike,
        node_readings: ArrayLike = (),
        node_ids: ArrayLike = (),
        boundary: bool = False,
        closed: bool = False,
        sharp: bool = False,
        name: str = "",
        turns: ArrayLike | None = None,
        turn_times: ArrayLike | None = None,
    ) -> None: ...

class Scan:
    curves: list[ScanCurve]
    unit: str
    tangents: str
    warnings: list[str]
    report: Any
    def __init__(self, curves: Iterable[ScanCurve], unit: str = "", tangents: str = "auto") -> None: ...

class SensorLog:
    time: Any
    curve: Any
    node: Any
    distance: Any
    accelerometer: Any
    magnetometer: Any
    gyroscope: Any
    forward: Any
    normal: Any
    curves: list[Any]
    warnings: list[str]
    def __init__(
        self,
        time: ArrayLike,
        curves: Iterable[Mapping[str, Any]],
        curve: ArrayLike,
        node: ArrayLike,
        distance: ArrayLike,
        accelerometer: ArrayLike,
        magnetometer: ArrayLike,
        gyroscope: ArrayLike,
        forward: ArrayLike = (1.0, 0.0, 0.0),
        normal: ArrayLike = (0.0, 0.0, 1.0),
    ) -> None: ...

class Simulation:
    scan: Scan
    log: Any
    tumble: Any
    truth: Any
    truth_network: Any
    report: dict[str, Any]
    warnings: list[str]
    def __init__(
        self,
        scan: Scan,
        log: SensorLog | None,
        tumble: SensorLog | None,
        truth: Mesh | None,
        truth_network: Network | None,
        report: dict[str, Any],
    ) -> None: ...

class SurfaceSolver:
    def __init__(
        self,
        network: Network,
        *,
        rebuilds: str | int = "auto",
        method: str = "curvature",
        constraints: str = "hard",
        soft_weight: float = 1.0,
        map: str = "plane",
        base_order: int = 2,
        edge_length: str | float = "auto",
        max_triangles: float = 20000000.0,
        progress: Progress | None = None,
    ) -> None: ...
    def move(
        self,
        positions: ArrayLike,
        normals: ArrayLike,
        *,
        reach: str = "touched",
        positions_only: bool = False,
        progress: Progress | None = None,
    ) -> dict[str, Any]: ...
    @property
    def positions(self) -> NDArray[np.float64]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def triangles(self) -> NDArray[np.int32]: ...
    @property
    def patch_of_triangle(self) -> NDArray[np.int32]: ...
    @property
    def on_network(self) -> NDArray[np.bool_]: ...
    @property
    def warnings(self) -> list[str]: ...

class ReconstructionSolver:
    def __init__(self, scan: Scan) -> None: ...
    def solve(
        self,
        *,
        step: str | float = "1.6%",
        weights: str | tuple[float, float] = "auto",
        energy: str = "scaled",
        xi: float = 10000.0,
        robust: str = "on",
        scheme: str = "midpoint",
        uncertainty: bool = False,
        lengths: str = "measured",
        progress: Progress | None = None,
    ) -> Network: ...
    def follow(
        self,
        *,
        step: str | float = "1.6%",
        weights: str | tuple[float, float] = "auto",
        energy: str = "scaled",
        xi: float = 10000.0,
        robust: str = "on",
        scheme: str = "midpoint",
        uncertainty: bool = False,
        lengths: str = "measured",
        progress: Progress | None = None,
    ) -> Network: ...

Shape = Union[Mesh, Network, tuple[ArrayLike, ArrayLike]]

def carry_values(A: Mesh, B: Mesh, *, progress: Progress | None = None) -> Mesh: ...
def check(
    surface: Mesh | tuple[ArrayLike, ArrayLike],
    network: Network,
    *,
    continuity: str = "g1",
    tolerance: str | float = "0.5deg",
    gap: float = 0.1,
    curvature: float = 10,
    distance: float = 1,
    progress: Progress | None = None,
) -> CurveCheck: ...
def compare(
    A: Shape,
    B: Shape,
    *,
    register: str = "none",
    samples: int = 200000,
    seed: int = 1,
    repair: bool = False,
    progress: Progress | None = None,
) -> Comparison: ...
def deform(
    V: ArrayLike | Mesh,
    F: ArrayLike | None = None,
    *,
    handles: Mapping[str, Any],
    energy: str = "total",
    nonlinear: str = "gauss-newton",
    soft: float = 0.0,
    multiresolution: bool = False,
    iterations: int = 200,
    repair: bool = False,
    progress: Progress | None = None,
) -> Mesh: ...
def fair(
    V: ArrayLike | Mesh,
    F: ArrayLike | None = None,
    *,
    method: str = "auto",
    noise: str | float = "auto",
    iterations: int = 0,
    keep_boundary: bool = False,
    repair: bool = False,
    progress: Progress | None = None,
) -> Mesh: ...
def infer_nodes(scan: Scan, *, progress: Progress | None = None) -> Scan: ...
def network_from_scan(
    scan: Scan,
    *,
    step: str | float = "1.6%",
    weights: str | tuple[float, float] = "auto",
    energy: str = "scaled",
    xi: float = 10000.0,
    robust: str = "on",
    scheme: str = "midpoint",
    uncertainty: bool = False,
    nodes: str = "given",
    lengths: str = "measured",
    progress: Progress | None = None,
) -> Network: ...
def read_cage(path: Path) -> Cage: ...
def read_mesh(path: Path) -> Mesh: ...
def read_network(path: Path) -> Network: ...
def read_rawnet(path: Path, *, nodes: str = "given") -> Scan: ...
def read_scan(path: Path, *, calibration: Path | None = None, columns: str = "", nodes: str = "given") -> Scan: ...
def read_sensor_log(path: Path, *, columns: str = "") -> SensorLog: ...
def reconstruct(
    scan: Scan,
    *,
    rebuilds: str | int = "auto",
    method: str = "curvature",
    constraints: str = "hard",
    soft_weight: float = 1.0,
    map: str = "plane",
    base_order: int = 2,
    edge_length: str | float = "auto",
    max_triangles: float = 20000000.0,
    accept_flaws: bool = False,
    against: Shape | None = None,
    step: str | float = "1.6%",
    weights: str | tuple[float, float] = "auto",
    energy: str = "scaled",
    xi: float = 10000.0,
    robust: str = "on",
    scheme: str = "midpoint",
    uncertainty: bool = False,
    nodes: str = "given",
    lengths: str = "measured",
    progress: Progress | None = None,
) -> Surface: ...
def remesh(
    V: ArrayLike | Mesh,
    F: ArrayLike | None = None,
    *,
    edge: str | float | None = None,
    vertices: int = 0,
    adaptivity: float = 0.1,
    keep_edges: str | float = "30deg",
    keep_border: str = "curve",
    method: str = "ar",
    sizes: ArrayLike | str | None = None,
    iterations: int = 8,
    repair: bool = False,
    accept_flaws: bool = False,
    progress: Progress | None = None,
) -> Mesh: ...
def repair(
    V: ArrayLike | Mesh,
    F: ArrayLike | None = None,
    *,
    weld: str | float = "auto",
    orient: bool = False,
    fill_holes: str | int = 0,
    accept_flaws: bool = False,
    progress: Progress | None = None,
) -> Mesh: ...
def set_threads(n: int | str) -> None: ...
def simplify(
    V: ArrayLike | Mesh,
    F: ArrayLike | None = None,
    *,
    faces: int = 0,
    remove: str | float | None = None,
    error: str | float | None = None,
    levels: int = 3,
    method: str = "quadric",
    keep_edges: str | float = "off",
    keep_border: str = "shape",
    p: float = 0.1,
    alpha: float = 1.0,
    beta: float = 1.0,
    weight: str = "w3",
    sigma: float = 0.5,
    fidelity: str | float = "adaptive",
    keep_all_levels: bool = False,
    repair: bool = False,
    progress: Progress | None = None,
) -> Mesh: ...
def simulate(
    object: str | Mesh,
    *,
    seed: int = 0,
    step: str | float = "0.6%",
    jitter: float = 0.35,
    dwell: int = 3,
    orientation_noise: str | float = 0,
    drift: str | float = 0,
    drift_length: str | float = "15%",
    odometer_error: str | float = 0,
    outliers: str | float = 0,
    disturbance: str | float = 0,
    curve_length_error: str | float = 0,
    speed_variation: str | float = 0,
    nodes: str = "numbered",
    raw: bool = False,
    tumble: bool = False,
    sensor_noise: float = 1.0,
    distortion: bool = True,
    gyroscope: bool = False,
    gyroscope_rate: float = 100.0,
    gyroscope_bias: str | float | None = None,
    gyroscope_walk: str | float | None = None,
    gyroscope_scale: str | float | None = None,
    gyroscope_misalignment: str | float | None = None,
    gyroscope_temperature: str | float | None = None,
    gyroscope_warming: float = 3.0,
    planes: int = 3,
    axes: str = "x,y,z",
    truth: bool = False,
    truth_network: bool = False,
    truth_step: str | float = "0.05%",
    truth_edge: str | float = "0.3%",
    progress: Progress | None = None,
) -> Simulation: ...
def subdivide(
    cage: Cage | Mesh | tuple[ArrayLike, Any],
    *,
    scheme: str | Sequence[str] = "catmull-clark",
    levels: int = 3,
    limit: bool = False,
    corners: str = "sharp",
    knots: float = 0.5,
    progress: Progress | None = None,
) -> Subdivision: ...
def surface(
    network: Network,
    *,
    rebuilds: str | int = "auto",
    method: str = "curvature",
    constraints: str = "hard",
    soft_weight: float = 1.0,
    map: str = "plane",
    base_order: int = 2,
    edge_length: str | float = "auto",
    max_triangles: float = 20000000.0,
    accept_flaws: bool = False,
    weld: str | float = "auto",
    reach: str | float = "3%",
    step: str | float = "1.5%",
    topology: str = "auto",
    closed: str = "auto",
    symmetry: str = "auto",
    crossings: str = "flatten",
    uncertainty: bool = False,
    progress: Progress | None = None,
) -> Surface: ...
def threads() -> int: ...
def write_cage(path: Path, cage: Cage) -> None: ...
def write_mesh(
    path: Path,
    mesh: Mesh | ArrayLike,
    triangles: ArrayLike | None = None,
    *,
    ascii: bool = False,
    unit: str | None = None,
) -> None: ...
def write_network(path: Path, network: Network) -> None: ...
def write_rawnet(path: Path, scan: Scan) -> None: ...
def write_sensor_log(path: Path, log: SensorLog) -> None: ...
