"""Scans, curve networks and the surfaces through them."""

from . import _batten
from ._errors import InvalidInput
from ._meshes import Mesh, Surface, _mesh
from ._options import shape_of


class Network:
    """A curve network: curves are walks over shared vertices.

    Parameters
    ----------
    positions : array_like, n x 3
        In the unit of the network.
    curves : list of array_like of int
        The vertices of each curve, two at least; a closed curve repeats its first at the end. Curves meet where they
        share a vertex.
    normals : array_like, n x 3, optional
        Unit outward normals of the surface; without them the curves are taken for strokes.
    boundary : list of bool, optional
        Which curves lie on the border of an open surface.
    names : list of str, optional
    sharp : list of bool, optional
        Along which curves the surface has an edge.
    left_normals, right_normals : list of (array_like, k x 3, or None), optional
        Normals on both sides of sharp curves, one for each vertex of the curve.
    nodes : array_like of int, optional
        Vertices that are nodes although the curves alone would not show it.
    unit : str
        Of length, "mm" and the like; empty: not known.
    uncertainty : array_like, n, optional
        Standard deviation of each vertex, in the unit of the network.

    Attributes
    ----------
    warnings : list of str
        What was told when the network was read or made.
    report : dict or None
        Figures of the function that made it, under the keys of ``batten network --json``.
    """

    def __init__(
        self,
        positions,
        curves,
        normals=None,
        boundary=None,
        names=None,
        sharp=None,
        left_normals=None,
        right_normals=None,
        nodes=(),
        unit="",
        uncertainty=None,
    ):
        self.positions = positions
        self.curves = list(curves)
        self.normals = normals
        self.boundary = boundary
        self.names = names
        self.sharp = sharp
        self.left_normals = left_normals
        self.right_normals = right_normals
        self.nodes = nodes
        self.unit = unit
        self.uncertainty = uncertainty
        self.warnings = []
        self.report = None

    def __repr__(self):
        return f"<batten.Network: {len(self.curves)} curves, {len(self.positions)} vertices>"


class ScanCurve:
    """The readings along one curve.

    Parameters
    ----------
    distances : array_like, n
        Along the curve from its start, not decreasing.
    tangents, normals : array_like, n x 3
        Unit vectors in the world frame; normals point outward.
    node_readings : array_like of int
        The readings taken at nodes, increasing, counted from 0.
    node_ids : array_like of int
        The number of each of these nodes; -1 where it is not known.
    boundary, closed, sharp : bool
        Whether it lies on the border of an open surface; returns to its start (and first node); has an edge of the
        surface along it.
    name : str
    turns : array_like, n x 3, optional
        Of a gyroscope: rotation vectors from the reading before, in the axes of the frame; NaN where unknown.
    turn_times : array_like, n, optional
        Seconds since that reading.
    """

    def __init__(
        self,
        distances,
        tangents,
        normals,
        node_readings=(),
        node_ids=(),
        boundary=False,
        closed=False,
        sharp=False,
        name="",
        turns=None,
        turn_times=None,
    ):
        self.distances = distances
        self.tangents = tangents
        self.normals = normals
        self.node_readings = node_readings
        self.node_ids = node_ids
        self.boundary = boundary
        self.closed = closed
        self.sharp = sharp
        self.name = name
        self.turns = turns
        self.turn_times = turn_times

    def __repr__(self):
        return f"<batten.ScanCurve: {len(self.distances)} readings, {len(self.node_readings)} nodes>"


class Scan:
    """Orientations and distances along curves on an object: what a device records.

    Parameters
    ----------
    curves : list of ScanCurve
    unit : str
        Of the distances; empty: metres.
    tangents : str
        What a tangent means: "at-sample", "to-next", or "auto" to tell from the data.

    Attributes
    ----------
    warnings : list of str
        What was told when the scan was read.
    report : dict or None
        Of infer_nodes(): the nodes with their evidence.
    """

    def __init__(self, curves, unit="", tangents="auto"):
        self.curves = list(curves)
        self.unit = unit
        self.tangents = tangents
        self.warnings = []
        self.report = None

    def __repr__(self):
        return f"<batten.Scan: {len(self.curves)} curves, {sum(len(c.distances) for c in self.curves)} readings>"


class SensorLog:
    """Raw readings of a device, row by row. What it does not measure is NaN.

    Parameters
    ----------
    time : array_like, n
        Seconds.
    curves : list of dict
        "number", "name", "boundary", "closed" and "sharp" of each curve.
    curve, node : array_like of int, n
        Index of the curve and number of the node; -1 for none.
    distance : array_like, n
        Metres along the curve.
    accelerometer, magnetometer, gyroscope : array_like, n x 3
        Specific force in m/s^2, field in microtesla, angular rate in rad/s, in the axes of the device.
    forward, normal : array_like, 3
        Direction of travel and away from the surface, in the axes of the device.

    Attributes
    ----------
    warnings : list of str
        What was told when the log was read.
    """

    def __init__(
        self,
        time,
        curves,
        curve,
        node,
        distance,
        accelerometer,
        magnetometer,
        gyroscope,
        forward=(1.0, 0.0, 0.0),
        normal=(0.0, 0.0, 1.0),
    ):
        self.time = time
        self.curves = list(curves)
        self.curve = curve
        self.node = node
        self.distance = distance
        self.accelerometer = accelerometer
        self.magnetometer = magnetometer
        self.gyroscope = gyroscope
        self.forward = forward
        self.normal = normal
        self.warnings = []

    def __repr__(self):
        return f"<batten.SensorLog: {len(self.time)} readings, {len(self.curves)} curves>"


class Simulation:
    """A simulated scan with its truth.

    Attributes
    ----------
    scan : Scan
    log, tumble : SensorLog or None
        With ``raw=True``: what the sensors wrote, and a recording for calibration where that was asked for.
    truth : Mesh or None
    truth_network : Network or None
    report : dict
        Figures under the keys of ``batten simulate --json``.
    warnings : list of str
    """

    def __init__(self, scan, log, tumble, truth, truth_network, report):
        self.scan = scan
        self.log = log
        self.tumble = tumble
        self.truth = truth
        self.truth_network = truth_network
        self.report = report
        self.warnings = report["warnings"]

    def __repr__(self):
        return f"<batten.Simulation: {self.scan!r}>"


def _network(fields):
    """A network of the fields that the compiled module gives."""
    network = Network(
        fields["positions"],
        fields["curves"],
        fields["normals"],
        fields["boundary"],
        fields["names"],
        fields["sharp"],
        fields["left_normals"],
        fields["right_normals"],
        fields["nodes"],
        fields["unit"],
        fields.get("uncertainty"),
    )
    network.report = fields.get("report")
    network.warnings = fields.get("warnings", network.report["warnings"] if network.report else [])
    return network


def _scan(fields):
    scan = Scan([ScanCurve(**curve) for curve in fields["curves"]], fields["unit"], fields["tangents"])
    scan.warnings = fields.get("warnings", [])
    scan.report = fields.get("report")
    return scan


def _log(fields):
    warnings = fields.pop("warnings", [])
    log = SensorLog(**fields)
    log.warnings = warnings
    return log


def _surface(fields):
    network = _network(fields["network"])
    surface = _mesh(fields, Surface, unit=fields["unit"])
    surface.network = network
    surface.patch_of_triangle = fields["patch_of_triangle"]
    return surface


def _known(object, kind):
    if not isinstance(object, kind):
        raise InvalidInput(f"give a {kind.__name__}, got {type(object).__name__}")
    return object


def simulate(
    object,
    *,
    seed=0,
    step="0.6%",
    jitter=0.35,
    dwell=3,
    orientation_noise=0,
    drift=0,
    drift_length="15%",
    odometer_error=0,
    outliers=0,
    disturbance=0,
    curve_length_error=0,
    speed_variation=0,
    nodes="numbered",
    raw=False,
    tumble=False,
    sensor_noise=1.0,
    distortion=True,
    gyroscope=False,
    gyroscope_rate=100.0,
    gyroscope_bias=None,
    gyroscope_walk=None,
    gyroscope_scale=None,
    gyroscope_misalignment=None,
    gyroscope_temperature=None,
    gyroscope_warming=3.0,
    planes=3,
    axes="x,y,z",
    truth=False,
    truth_network=False,
    truth_step="0.05%",
    truth_edge="0.3%",
    progress=None,
):
    """Simulate the scan of a shape or of a mesh, with its truth.

    Lengths are numbers in the unit of the object or text ("0.6%" of its diameter, "2mm"), angles degrees or text ("2deg",
    "0.03rad"), fractions numbers or text ("0.3%").

    Parameters
    ----------
    object : str or Mesh
        "sphere", "sphere6", "ellipsoid", "torus", "bumpycube", "saddle", "waves", "dish", "cone", or a mesh that planes
        cut.
    seed : int
        Of all random numbers.
    step : str or float
        Mean distance between readings.
    jitter : float
        Largest shift of a reading, in steps, 0 to 0.49.
    dwell : int
        Readings at every node, at least 1.
    orientation_noise, drift : str or float
        White noise and slow drift of the frames, angles per axis.
    drift_length : str or float
        Distance over which the drift forgets itself.
    odometer_error, curve_length_error, speed_variation, outliers : str or float
        Spread of the scale of distances per curve; curve lengths wrong by up to this; speed up and down by up to this
        where distances come from time stamps; share of readings with a random orientation.
    disturbance : str or float
        Turn the heading on a tenth of one curve by up to this angle.
    nodes : str
        "numbered"; "stays": marked without numbers; "none": no marks, the device rests.
    raw, tumble : bool
        Also what the sensors of the device write, and with it a recording for calibration.
    sensor_noise : float
        With `raw`: factor on the noise of the sensors; 0: none.
    distortion : bool
        With `raw`: zero errors, scales and soft iron that need a calibration.
    gyroscope, gyroscope_rate, gyroscope_bias, gyroscope_walk, gyroscope_scale, gyroscope_misalignment,
    gyroscope_temperature, gyroscope_warming
        With `raw`: a gyroscope that is read all the time, its readings per second, and its errors (docs/simulate.md).
    planes, axes
        Of a mesh: planes per axis, 1 to 100, and the axes across which they are laid.
    truth, truth_network : bool
        Also the true surface and the true curves.
    truth_step, truth_edge : str or float
        Distance between the points of the true curves; length of the edges of a shape's true mesh.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Simulation

    Raises
    ------
    InvalidInput
        On arguments out of range or that do not go together, and on meshes that no plane meets.
    Cancelled
    """
    options = dict(
        seed=seed,
        step=step,
        jitter=jitter,
        dwell=dwell,
        orientation_noise=orientation_noise,
        drift=drift,
        drift_length=drift_length,
        odometer_error=odometer_error,
        outliers=outliers,
        disturbance=disturbance,
        curve_length_error=curve_length_error,
        speed_variation=speed_variation,
        nodes=nodes,
        raw=raw,
        sensor_noise=sensor_noise,
        distortion=distortion,
        gyroscope=gyroscope,
        gyroscope_rate=gyroscope_rate,
        gyroscope_bias=gyroscope_bias,
        gyroscope_walk=gyroscope_walk,
        gyroscope_scale=gyroscope_scale,
        gyroscope_misalignment=gyroscope_misalignment,
        gyroscope_temperature=gyroscope_temperature,
        gyroscope_warming=gyroscope_warming,
        planes=planes,
        axes=axes,
        truth_step=truth_step,
        truth_edge=truth_edge,
    )
    if not isinstance(object, str):
        _known(object, Mesh)
    made = _batten.simulate(object, bool(truth), bool(truth_network), bool(tumble), options, progress)
    return Simulation(
        _scan(made["scan"]),
        None if made["log"] is None else _log(made["log"]),
        None if made["tumble"] is None else _log(made["tumble"]),
        None if made["truth"] is None else _mesh(made["truth"]),
        None if made["truth_network"] is None else _network(made["truth_network"]),
        made["report"],
    )


def infer_nodes(scan, *, progress=None):
    """Find which stays of a scan lie at the same node, with the evidence.

    Parameters
    ----------
    scan : Scan
        Nodes with the number -1, or curves on which the device only rested.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Scan
        With numbers for all nodes; ``report["doubts"]`` is empty where they are sure.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on scans without stays.
    Cancelled
    """
    return _scan(_batten.infer_nodes(_known(scan, Scan), progress))


def network_from_scan(
    scan,
    *,
    step="1.6%",
    weights="auto",
    energy="scaled",
    xi=10000.0,
    robust="on",
    scheme="midpoint",
    uncertainty=False,
    nodes="given",
    lengths="measured",
    progress=None,
):
    """Turn a scan of orientations and distances into a curve network with positions and normals.

    Parameters
    ----------
    scan : Scan
    step : str or float
        Distance between samples: a part of the size ("1.6%"), a length, or "none" for the readings themselves.
    weights : str or pair of float
        "auto": from the data; "thesis"; or lambda and mu with lengths in sizes.
    energy : str
        Form of the smoothing energy: "scaled", free of resolution and unit, or "thesis", as printed.
    xi : float
        Weight of equal normals at nodes, at least 0.
    robust : str
        "on": distrust outliers and disturbed pieces; or "off".
    scheme : str
        Integration: "midpoint", fourth order, or "thesis", first order.
    uncertainty : bool
        Tell how sure every vertex is: ``uncertainty`` of the network, and figures.
    nodes : str
        "given": as numbered in the scan; "auto": as infer_nodes() finds them; an Error where that is not sure.
    lengths : str
        "measured", or "estimated" from time stamps.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Network
        One curve for each of the scan, nodes first among the vertices, with ``report``.

    Raises
    ------
    InvalidInput
        With curve, reading or node and the remedy.
    SolverFailure, Cancelled
    """
    options = dict(
        step=step,
        weights=weights,
        energy=energy,
        xi=xi,
        robust=robust,
        scheme=scheme,
        uncertainty=uncertainty,
        nodes=nodes,
        lengths=lengths,
    )
    return _network(_batten.network_from_scan(_known(scan, Scan), options, progress))


def surface(
    network,
    *,
    rebuilds="auto",
    method="curvature",
    constraints="hard",
    soft_weight=1.0,
    map="plane",
    base_order=2,
    edge_length="auto",
    max_triangles=2e7,
    accept_flaws=False,
    weld="auto",
    reach="3%",
    step="1.5%",
    topology="auto",
    closed="auto",
    symmetry="auto",
    crossings="flatten",
    uncertainty=False,
    progress=None,
):
    """Fill a curve network, or a sketch without normals, with a fair surface.

    Parameters
    ----------
    network : Network
    rebuilds : str or int
        Rebuilds of the Laplacian from the solved mesh: "auto", or 0 to 20.
    method : str
        "curvature", or a baseline: "harmonic", "biharmonic", "triharmonic", "biharmonic-normals".
    constraints : str
        "hard": through the curves exactly; "soft": near them, for noisy curves.
    soft_weight : float
        Weight of soft constraints, above 0; no unit.
    map : str
        Plane layout of patches: "plane", "circle", "polygon".
    base_order : int
        Power of the Laplacian of the base geometry: 1, 2, 3.
    edge_length : str or float
        Length of edges inside patches: a number in the unit of the network, "2mm", "1.5%" of the diameter, or "auto": 0.71
        of the mean edge of the curves.
    max_triangles : float
        Refuse surfaces that would have more triangles than this.
    accept_flaws : bool
        Return a surface that crosses itself, folds, collapses or leaves its curves, with a warning.
    weld : str or float
        Curves this near meet; "auto": what gives the simplest surface; 0: networks with normals are taken as they are.
    reach : str or float
        Without normals: ends are extended to a stroke this near; or "none".
    step : str or float
        Without normals: distance of samples on the cleaned curves, or "none" for those of the network.
    topology : str
        Without normals: "cycles": patches between strokes that meet; "implicit": one closed surface through all strokes,
        which need not meet; "auto": cycles where they are sure.
    closed : str
        Without normals: whether the surface is closed: "auto", "yes", or "no" (by cycles alone).
    symmetry : str
        Without normals: "x", "y", "z": strokes are completed in the mirror x = 0 and the like; "auto": those of an implicit
        surface that are nearly their own image; "off".
    crossings : str
        Without normals: patches that would cross others or fold are filled flatter ("flatten"), or kept ("keep").
    uncertainty : bool
        Tell how sure every vertex is: ``uncertainty`` of the surface, and figures.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Surface
        With normals, ``patch_of_triangle``, the ``network`` that was filled and ``report``.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on networks that cannot be filled, with curve and node.
    Error
        Where the surface is not sound and that is not accepted.
    SolverFailure, Cancelled
    """
    options = dict(
        rebuilds=rebuilds,
        method=method,
        constraints=constraints,
        soft_weight=soft_weight,
        map=map,
        base_order=base_order,
        edge_length=edge_length,
        max_triangles=max_triangles,
        accept_flaws=accept_flaws,
        weld=weld,
        reach=reach,
        step=step,
        topology=topology,
        closed=closed,
        symmetry=symmetry,
        crossings=crossings,
        uncertainty=uncertainty,
    )
    return _surface(_batten.surface(_known(network, Network), options, progress))


def reconstruct(
    scan,
    *,
    rebuilds="auto",
    method="curvature",
    constraints="hard",
    soft_weight=1.0,
    map="plane",
    base_order=2,
    edge_length="auto",
    max_triangles=2e7,
    accept_flaws=False,
    against=None,
    step="1.6%",
    weights="auto",
    energy="scaled",
    xi=10000.0,
    robust="on",
    scheme="midpoint",
    uncertainty=False,
    nodes="given",
    lengths="measured",
    progress=None,
):
    """Turn a scan of orientations and distances into a fair surface.

    Parameters
    ----------
    scan : Scan
    against : Mesh, Network or pair (positions, triangles), optional
        Known to be true: adds ``report["error_percent"]`` and the value "error_percent" per vertex, after a rigid motion.
    rebuilds, method, constraints, soft_weight, map, base_order, edge_length, max_triangles, accept_flaws
        As surface() has them.
    step, weights, energy, xi, robust, scheme, uncertainty, nodes, lengths
        As network_from_scan() has them.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Returns
    -------
    Surface
        With the ``network``, and ``report`` with the figures of both under "network" and "surface".

    Raises
    ------
    InvalidInput
        With curve, reading, node or patch and the remedy.
    Error
        Where the surface is not sound and that is not accepted.
    SolverFailure, Cancelled
    """
    options = dict(
        rebuilds=rebuilds,
        method=method,
        constraints=constraints,
        soft_weight=soft_weight,
        map=map,
        base_order=base_order,
        edge_length=edge_length,
        max_triangles=max_triangles,
        accept_flaws=accept_flaws,
        step=step,
        weights=weights,
        energy=energy,
        xi=xi,
        robust=robust,
        scheme=scheme,
        uncertainty=uncertainty,
        nodes=nodes,
        lengths=lengths,
    )
    truth = None if against is None else shape_of(against)
    return _surface(_batten.reconstruct(_known(scan, Scan), truth, options, progress))
