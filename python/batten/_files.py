"""Files. Formats are those of the program (docs/files.md); the extension decides when writing."""

import warnings as _warnings

from . import _batten
from ._errors import InvalidInput
from ._meshes import Cage, Mesh, _cage, _mesh
from ._networks import Network, Scan, SensorLog, _known, _log, _network, _scan
from ._options import path_of


def _tell(path, losses):
    for loss in losses:
        _warnings.warn(f"{path}: {loss}", stacklevel=3)


def read_mesh(path):
    """Read a mesh: PLY, OBJ, OFF, STL, glTF or 3MF, packed with gzip or not. Polygons are split into triangles.

    Parameters
    ----------
    path : str or path-like

    Returns
    -------
    Mesh
        With normals and values where the file has them, and ``warnings`` with what was split or left out.

    Raises
    ------
    FileError
        Naming line or element, what was expected and the remedy.
    """
    path = path_of(path)
    return _mesh(_batten.read_mesh(path), name=path)


def write_mesh(path, mesh, triangles=None, *, ascii=False, unit=None):
    """Write a mesh: .ply (keeps everything bit for bit), .obj, .off, .stl, .glb or .3mf.

    The file appears under its name when it is whole. What the format cannot hold is told by a warning of Python.

    Parameters
    ----------
    path : str or path-like
    mesh : Mesh, or array_like n x 3 with `triangles`
    triangles : array_like of int, m x 3, optional
    ascii : bool
        Text instead of bytes, for PLY and STL.
    unit : str, optional
        Of length, for .glb and .3mf: "mm", "in", ...; None: that of the mesh, else "m".

    Raises
    ------
    FileError
        When the file cannot be written, and on other extensions.
    InvalidInput
        On arguments out of range, with row and value.
    """
    if triangles is not None:
        mesh = Mesh(mesh, triangles)
    _known(mesh, Mesh)
    path = path_of(path)
    _tell(path, _batten.write_mesh(path, mesh, bool(ascii), unit or mesh.unit or "m"))


def read_network(path):
    """Read a curve network: .net, .obj with lines, .json, .txt or .lop.

    Parameters
    ----------
    path : str or path-like

    Returns
    -------
    Network
        With ``uncertainty`` where the file has it, and ``warnings``.

    Raises
    ------
    FileError
        Naming the line, what was expected and the remedy.
    """
    return _network(_batten.read_network(path_of(path)))


def write_network(path, network):
    """Write a network as .net, .obj or .json. Numbers read back bit for bit; only .json holds everything.

    What the format cannot hold is told by a warning of Python.

    Parameters
    ----------
    path : str or path-like
    network : Network

    Raises
    ------
    FileError
        When the file cannot be written, and on other extensions.
    InvalidInput
        On arguments out of range, with row and value.
    """
    path = path_of(path)
    _tell(path, _batten.write_network(path, _known(network, Network)))


def read_scan(path, *, calibration=None, columns="", nodes="given"):
    """Read a scan: .rawnet, or a log of sensor readings (.csv), whose readings become orientations.

    Parameters
    ----------
    path : str or path-like
    calibration : str or path-like, optional
        File with the calibration of the device that wrote a log (``batten calibrate``).
    columns : str
        Logs of other programs: "auto", or what holds what, as ``time=t_ms:ms,acc=ax:ay:az:g``.
    nodes : str
        "given": nodes must have their numbers; "auto": they may miss, for infer_nodes().

    Returns
    -------
    Scan

    Raises
    ------
    FileError
        With line, what was expected and the remedy.
    InvalidInput
    """
    calibration = None if calibration is None else path_of(calibration)
    return _scan(_batten.read_scan(path_of(path), calibration, columns, nodes))


def read_rawnet(path, *, nodes="given"):
    """Read a scan from a rawnet file. See read_scan()."""
    return read_scan(path, nodes=nodes)


def write_rawnet(path, scan):
    """Write a scan as .rawnet, which read_rawnet() reads back as exactly the same.

    Parameters
    ----------
    path : str or path-like
    scan : Scan

    Raises
    ------
    FileError
        When the file cannot be written.
    InvalidInput
        On arguments out of range, with row and value.
    """
    _batten.write_rawnet(path_of(path), _known(scan, Scan))


def read_sensor_log(path, *, columns=""):
    """Read a log of sensor readings (.csv) row by row.

    Parameters
    ----------
    path : str or path-like
    columns : str
        Logs of other programs: "auto", or what holds what. See read_scan().

    Returns
    -------
    SensorLog

    Raises
    ------
    FileError
        With line, what was expected and the remedy.
    InvalidInput
    """
    return _log(_batten.read_sensor_log(path_of(path), columns))


def write_sensor_log(path, log):
    """Write a log that read_sensor_log() reads back as exactly the same.

    Parameters
    ----------
    path : str or path-like
    log : SensorLog

    Raises
    ------
    FileError
        When the file cannot be written.
    InvalidInput
        On arguments out of range, with row and value.
    """
    _batten.write_sensor_log(path_of(path), _known(log, SensorLog))


def read_cage(path):
    """Read a cage for subdivision: the polygons of PLY, OBJ, OFF or STL as they are, with what OBJ says is sharp.

    Parameters
    ----------
    path : str or path-like

    Returns
    -------
    Cage

    Raises
    ------
    FileError
        Naming the line, what was expected and the remedy.
    """
    return _cage(_batten.read_cage(path_of(path)))


def write_cage(path, cage):
    """Write a cage without splitting its polygons: .obj with what is sharp, .ply or .off with the faces alone.

    Parameters
    ----------
    path : str or path-like
    cage : Cage
        A Subdivision too.

    Raises
    ------
    FileError
        When the file cannot be written, and on other extensions.
    InvalidInput
        On arguments out of range, naming face, edge or vertex.
    """
    if not isinstance(cage, Cage):
        raise InvalidInput(f"give a Cage, got {type(cage).__name__}")
    _batten.write_cage(path_of(path), cage)
