"""What the tests share. They run the package that PYTHONPATH names beside the program of the same build."""

import functools
import inspect
import json
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest

import batten

ROOT = pathlib.Path(__file__).resolve().parents[2]
# build/<preset>/python/batten/_batten...so: the program of the same build is two folders up.
BUILD = pathlib.Path(batten._batten.__file__).absolute().parents[2]
PROGRAM = pathlib.Path(os.environ.get("BATTEN_PROGRAM", BUILD / "bin" / "batten"))


def torus(n, m=None, wave=0.02):
    """A torus of n x m cells: 2 n m triangles, outward; with a small wave, so that no two places are alike."""
    m = n // 2 if m is None else m
    u, v = np.meshgrid(2 * np.pi * np.arange(n) / n, 2 * np.pi * np.arange(m) / m, indexing="ij")
    r = 1 + 0.4 * np.cos(v)
    V = np.stack([r * np.cos(u), r * np.sin(u), 0.4 * np.sin(v) + wave * np.sin(7 * u)], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    c, d = ((i + 1) % n * m + (j + 1) % m).ravel(), (i * m + (j + 1) % m).ravel()
    F = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]).astype(np.int32)
    return V, F


def noisy_torus(n, amount=0.004, seed=1):
    V, F = torus(n)
    return V + np.random.default_rng(seed).normal(0, amount, V.shape), F


class Program:
    """The program batten, run as users do."""

    def __init__(self, folder):
        self.folder = folder

    def __call__(self, *arguments):
        """The object of --json of a run. Files are relative to the folder."""
        if not PROGRAM.exists():
            pytest.skip(f"the program is not built: {PROGRAM}")
        run = subprocess.run(
            [PROGRAM, *map(str, arguments), "--json"], cwd=self.folder, capture_output=True, text=True, check=False
        )
        assert run.returncode == 0, run.stderr
        return json.loads(run.stdout)


@pytest.fixture
def program(tmp_path):
    return Program(tmp_path)


@functools.lru_cache(maxsize=None)
def help_of_program(command):
    if not PROGRAM.exists():
        pytest.skip(f"the program is not built: {PROGRAM}")
    text = subprocess.run([PROGRAM, command, "--help"], capture_output=True, text=True, check=True).stdout
    return text.split("Simulate a pen:")[0]


def options_of_program(command):
    """The options that --help lists: name to default, as text; "" without one, False for switches."""
    kind = r"(?:TEXT|U?INT|FLOAT)(?::(?:\{[^}]*\}|\w+ in \[[^]]*\]|auto or a number|[^\s=]+))?"
    option = re.compile(rf"  (?:-\w,)?--([a-z-]+)(?: ({kind})(?:=(\S+))?|(,--no-\S+)?)(?: |$)")
    options = {}
    for line in help_of_program(command).splitlines():
        if found := option.match(line):
            name, takes, default, has_no = found.groups()
            options[name.replace("-", "_")] = (default or "") if takes else has_no is not None
    return options


def keywords_of(function):
    """The parameters of a function that are given by keyword, with their defaults."""
    return {
        p.name: p.default for p in inspect.signature(function).parameters.values() if p.kind == p.KEYWORD_ONLY
    }
