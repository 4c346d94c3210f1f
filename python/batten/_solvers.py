"""What is built once and solved many times."""

from . import _batten
from ._networks import Network, Scan, _known, _network


class SurfaceSolver:
    """The surface of a network, kept for further solves: build once, then move the curves or turn their normals.

    The network is taken as it is (nothing is welded), and what surface() checks at the end is not. Several threads may
    share a solver; they wait for each other.

    Parameters
    ----------
    network : Network
        With normals.
    rebuilds, method, constraints, soft_weight, map, base_order, edge_length, max_triangles
        As surface() has them.
    progress : callable of (str, float), optional
        Told the stage and the fraction done, at most every 20 ms; returns False to stop.

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value, and on networks that cannot be filled, with curve and node.
    SolverFailure, Cancelled
    """

    def __init__(
        self,
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
        progress=None,
    ):
        options = dict(
            rebuilds=rebuilds,
            method=method,
            constraints=constraints,
            soft_weight=soft_weight,
            map=map,
            base_order=base_order,
            edge_length=edge_length,
            max_triangles=max_triangles,
        )
        self._solver = _batten.SurfaceSolver(_known(network, Network), options, progress)

    def move(self, positions, normals, *, reach="touched", positions_only=False, progress=None):
        """Solve again for moved vertices and turned normals of the same network.

        The result depends on the surface that was built and on this call alone: moves do not add up errors.

        Parameters
        ----------
        positions, normals : array_like, n x 3
            As in the network.
        reach : str
            "touched": the patches around curves that lie or look otherwise; "all": what happens in a patch is felt in its
            neighbours too.
        positions_only : bool
            For while a curve is dragged: the normals of the surface wait for the next whole move. A third of the time.
        progress : callable of (str, float), optional
            Told the stage and the fraction done, at most every 20 ms; returns False to stop.

        Returns
        -------
        dict
            "positions" and "normals": lists of (first, end), the vertices that have changed; "patches_solved".

        Raises
        ------
        InvalidInput
            On other sizes or numbers that are not finite; the surface is then as before.
        SolverFailure
            The same.
        Cancelled
            The move goes on to its end; whoever asks next waits for it.
        """
        return self._solver.move(positions, normals, reach, positions_only, progress)

    @property
    def positions(self):
        """Vertices of the surface, k x 3, as they are now; those of the network come first. A copy."""
        return self._solver.positions

    @property
    def normals(self):
        """Unit normals of the vertices, k x 3. A copy."""
        return self._solver.normals

    @property
    def triangles(self):
        """Vertices of the triangles, m x 3; they stay."""
        return self._solver.triangles

    @property
    def patch_of_triangle(self):
        """The patch that each triangle fills, m."""
        return self._solver.patch_of_triangle

    @property
    def on_network(self):
        """Which vertices lie on a curve, k."""
        return self._solver.on_network

    @property
    def warnings(self):
        """What was told when the surface was built."""
        return self._solver.warnings


class ReconstructionSolver:
    """network_from_scan() kept for one scan, for sliders: what does not depend on the options is done once.

    Several threads may share a solver; they wait for each other.

    Parameters
    ----------
    scan : Scan

    Raises
    ------
    InvalidInput
        On arguments out of range, with row and value.
    """

    def __init__(self, scan):
        self._solver = _batten.ReconstructionSolver(_known(scan, Scan))

    def solve(
        self,
        *,
        step="1.6%",
        weights="auto",
        energy="scaled",
        xi=10000.0,
        robust="on",
        scheme="midpoint",
        uncertainty=False,
        lengths="measured",
        progress=None,
    ):
        """The network at rest: the same bits as network_from_scan(), whatever was asked before.

        Parameters, result and errors are those of network_from_scan().
        """
        options = dict(
            step=step,
            weights=weights,
            energy=energy,
            xi=xi,
            robust=robust,
            scheme=scheme,
            uncertainty=uncertainty,
            lengths=lengths,
        )
        return _network(self._solver.solve(False, options, progress))

    def follow(
        self,
        *,
        step="1.6%",
        weights="auto",
        energy="scaled",
        xi=10000.0,
        robust="on",
        scheme="midpoint",
        uncertainty=False,
        lengths="measured",
        progress=None,
    ):
        """The network while something moves: one or two steps from the last one. Else as solve().

        With automatic weights and the scaled energy the same as solve(): nothing but the readings is kept then.
        """
        options = dict(
            step=step,
            weights=weights,
            energy=energy,
            xi=xi,
            robust=robust,
            scheme=scheme,
            uncertainty=uncertainty,
            lengths=lengths,
        )
        return _network(self._solver.solve(True, options, progress))
