"""Progress, cancelling, Ctrl-C, the lock of the interpreter, threads of BLAS, memory."""

import ctypes
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import noisy_torus, torus

import batten

MOST_SECONDS = 0.2  # from Ctrl-C to KeyboardInterrupt
TRIES = 4  # on a busy machine the best of some


@pytest.fixture(scope="module")
def large():
    """A noisy mesh of 134,000 vertices."""
    V, F = noisy_torus(518, amount=0.0006)
    assert 133_000 < len(V) < 135_000
    return batten.Mesh(V, F, values={"height": V[:, 2].copy()})


@pytest.fixture(scope="module")
def scan():
    return batten.simulate("bumpycube", seed=1, step="0.15%", orientation_noise="1deg", drift="0.5deg").scan


@pytest.fixture(scope="module")
def network():
    return batten.simulate("bumpycube", truth_network=True, truth_step="1%").truth_network


def stages(work):
    """What `work(progress)` reports."""
    told = []
    work(lambda stage, fraction: told.append((stage, fraction)))
    return told


def test_progress_tells_stages_and_fractions():
    mesh = batten.Mesh(*noisy_torus(160))
    told = stages(lambda progress: batten.simplify(mesh, remove="50%", progress=progress))
    assert len(told) > 3
    assert all(isinstance(stage, str) and -1e-9 <= fraction <= 1 + 1e-9 for stage, fraction in told)
    assert len({stage for stage, _ in told}) > 1


def test_progress_that_returns_false_cancels_and_nothing_else_does(large):
    began = time.monotonic()
    with pytest.raises(batten.Cancelled, match="cancelled"):
        batten.simplify(large, remove="90%", progress=lambda stage, fraction: False)
    assert time.monotonic() - began < 5
    small = torus(24)
    for answer in (None, True, 0, ""):
        batten.fair(*small, progress=lambda stage, fraction: answer)


def test_errors_of_progress_are_those_of_the_call(large):
    def fail(stage, fraction):
        raise LookupError("of ours")

    with pytest.raises(LookupError, match="of ours"):
        batten.simplify(large, remove="90%", progress=fail)
    assert len(batten.fair(*torus(24)).positions) == 288  # and all is as before


def functions(large, scan, network):
    """A call of every function that works long, on something large."""
    V, F = large
    fixed = np.flatnonzero(V[:, 0] < -1.2)
    moved = np.flatnonzero(V[:, 0] > 1.2)
    handles = {"fixed": {"vertices": fixed}, "handles": [{"select": {"vertices": moved}, "translate": [0.1, 0, 0]}]}
    cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    shifted = batten.Mesh(V + [0.01, 0, 0], F)
    return {
        "fair": lambda: batten.fair(large, method="nlsdf"),
        "fair, automatic": lambda: batten.fair(large, noise=0.3),
        "remesh": lambda: batten.remesh(large),
        "simplify": lambda: batten.simplify(large, remove="90%"),
        "repair": lambda: batten.repair(large, orient=True),
        "deform": lambda: batten.deform(large, handles=handles),
        "subdivide": lambda: batten.subdivide((cube, faces), levels=9, limit=True),
        "compare": lambda: batten.compare(large, shifted, register="rigid", samples=1_000_000),
        "carry_values": lambda: batten.carry_values(large, shifted),
        "simulate": lambda: batten.simulate(large, planes=40, step="0.02%", truth=True),
        "network_from_scan": lambda: batten.network_from_scan(scan, step="0.2%", uncertainty=True),
        "reconstruct": lambda: batten.reconstruct(scan, edge_length="0.5%"),
        "surface": lambda: batten.surface(network, edge_length="0.45%"),
        "SurfaceSolver": lambda: batten.SurfaceSolver(network, edge_length="0.45%"),
        "ReconstructionSolver": lambda: batten.ReconstructionSolver(scan).solve(step="0.2%"),
    }


def latency(call, wait):
    """Seconds from Ctrl-C to KeyboardInterrupt; None where the call had ended before.

    By the clock, or in processor time of all threads where that is less: on a busy machine the clock tells how busy it is, and
    work that does not stop uses both.
    """
    sent = []

    def interrupt():
        time.sleep(wait)
        sent.extend([time.monotonic(), time.process_time()])
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    try:
        thread.start()
        call()
        thread.join()
        time.sleep(0.05)
    except KeyboardInterrupt:
        ended = time.monotonic(), time.process_time()
        thread.join()
        return min(ended[0] - sent[0], ended[1] - sent[1]) if sent else None
    return None


NAMES = list(functions(batten.Mesh(np.zeros((1, 3)), []), None, None))


@pytest.mark.parametrize("name", NAMES)
def test_every_function_is_interrupted_at_once(name, large, scan, network, record_property):
    call = functions(large, scan, network)[name]
    measured = []
    for attempt in range(TRIES):
        # At another moment each time; a function that is faster than that is interrupted earlier.
        seconds = latency(call, wait=0.35 / (attempt + 1))
        if seconds is not None:
            measured.append(seconds)
            if seconds <= MOST_SECONDS:
                break
    assert measured, f"{name} ended before it was interrupted"
    record_property("latency", min(measured))
    print(f"{name}: {1000 * min(measured):.0f} ms")
    assert min(measured) <= MOST_SECONDS


def test_reading_and_writing_is_interrupted_at_once(large, tmp_path):
    batten.write_mesh(tmp_path / "a.obj", *large)
    for call in (
        lambda: [batten.read_mesh(tmp_path / "a.obj") for _ in range(20)],
        lambda: [batten.write_mesh(tmp_path / "b.obj", *large) for _ in range(20)],
    ):
        assert min(seconds for _ in range(2) if (seconds := latency(call, 0.15)) is not None) <= MOST_SECONDS


def test_an_interrupted_solver_goes_on_to_work(network):
    solver = batten.SurfaceSolver(network, edge_length="1.5%")
    before = solver.positions
    moved = network.positions.copy()
    moved[5] += 0.01
    latency(lambda: [solver.move(moved, network.normals, reach="all") for _ in range(50)], 0.1)
    solver.move(network.positions, network.normals, reach="all")
    np.testing.assert_allclose(solver.positions, before, atol=1e-12)


def test_the_interpreter_ends_well_after_an_interrupt():
    """In the middle of what cannot be stopped at once, too."""
    code = (
        "import os, signal, threading, numpy, batten\n"
        "from conftest import torus\n"
        "mesh = batten.Mesh(*torus(300))\n"
        "V = mesh.positions\n"
        "handles = {'fixed': {'vertices': numpy.flatnonzero(V[:, 0] < -1.2)}, 'handles': [{'select': {'vertices':\n"
        "  numpy.flatnonzero(V[:, 0] > 1.2)}, 'translate': [0.1, 0, 0]}]}\n"
        "threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        "  batten.deform(mesh, handles=handles)\n"
        "except KeyboardInterrupt:\n"
        "  print('interrupted')\n"
    )
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([*sys.path, str(pathlib.Path(__file__).parent)]))
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "interrupted\n", "")


def test_other_threads_of_python_go_on(large):
    ticks, done = [], threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    began = time.monotonic()
    batten.compare(large, batten.Mesh(large.positions + [0.01, 0, 0], large.triangles), samples=300_000)
    ended = time.monotonic()
    done.set()
    thread.join()
    during = [t for t in ticks if began < t < ended]
    # With the lock held there would be one or two. Half the ticks of the time may be lost to a busy machine.
    assert len(during) > 20
    assert ended - began > 0.1


def test_two_threads_work_at_once_and_get_the_same():
    mesh = batten.Mesh(*noisy_torus(60))
    wanted = batten.fair(mesh).positions
    found = []
    threads = [threading.Thread(target=lambda: found.append(batten.fair(mesh).positions)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 4
    for positions in found:
        np.testing.assert_array_equal(positions, wanted)


def openblas():
    """All libraries of OpenBLAS in the process."""
    paths = {line.split()[-1] for line in open("/proc/self/maps", encoding="utf8") if "openblas" in line}
    return [ctypes.CDLL(path) for path in paths]


def test_threads_of_blas_are_as_found(network):
    found = openblas()
    if not found:
        pytest.skip("there is no OpenBLAS in this process")
    for threads in (2, 1):
        for library in found:
            library.openblas_set_num_threads(threads)
        batten.surface(network, edge_length="2%")
        latency(lambda: batten.surface(network, edge_length="0.5%"), 0.5)
        deadline = time.monotonic() + 20  # what was left to itself puts it back at its end
        while time.monotonic() < deadline and any(b.openblas_get_num_threads() != threads for b in found):
            time.sleep(0.05)
        assert [b.openblas_get_num_threads() for b in found] == [threads] * len(found)


def resident_bytes():
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE")


def small_calls():
    V, F = noisy_torus(12)
    mesh = batten.Mesh(V, F)
    network = batten.simulate("dish", truth_network=True, truth_step="12%").truth_network
    scan = batten.simulate("dish", step="9%").scan
    solver = batten.SurfaceSolver(network)
    handles = {"fixed": {"vertices": [0, 1, 2]}, "handles": [{"select": {"vertices": [40]}, "translate": [0, 0, 0.1]}]}
    bad = F.copy()
    bad[3, 0] = -1

    def refused():
        with pytest.raises(batten.InvalidInput):
            batten.fair(V, bad)

    return {
        "fair": lambda: batten.fair(V, F),
        "repair": lambda: batten.repair(mesh),
        "remesh": lambda: batten.remesh(mesh, iterations=1, accept_flaws=True),
        "simplify": lambda: batten.simplify(mesh, remove=0.2, keep_all_levels=True),
        "deform": lambda: batten.deform(mesh, handles=handles),
        "subdivide": lambda: batten.subdivide((V, F), levels=1),
        "compare": lambda: batten.compare(mesh, mesh, samples=100),
        "surface": lambda: batten.surface(network, rebuilds=0),
        "move": lambda: solver.move(network.positions + 0.001, network.normals),
        "network_from_scan": lambda: batten.network_from_scan(scan, weights=(1, 100), step="none"),
        "simulate": lambda: batten.simulate("dish", step="9%"),
        "refused": refused,
    }


def test_a_thousand_calls_keep_no_memory():
    calls = small_calls()
    slow = {name: calls.pop(name) for name in ("remesh", "simplify")}  # they measure by 200,000 samples
    rounds = 1000 // len(calls)

    def run(n):
        for i in range(n):
            for call in calls.values():
                call()
            if i % 10 == 0:
                for call in slow.values():
                    call()

    run(rounds // 3)  # what is kept once, and what the allocator keeps for later
    before = resident_bytes()
    run(rounds)
    grown = (resident_bytes() - before) / 1e6
    print(f"{rounds * len(calls) + rounds // 5} calls: {grown:.1f} MB")
    assert grown <= 5
