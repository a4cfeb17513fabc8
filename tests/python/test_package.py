"""The package as a whole: no MPI, types, the command line."""

import pathlib
import subprocess
import sys

import ringsplat as rs
from conftest import HEAD

FOLDER = pathlib.Path(rs.__file__).resolve().parent


def python(*words, **options):
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, **options)


def test_importing_loads_no_mpi():
    code = (
        "import ringsplat, sys; maps = open('/proc/self/maps').read(); "
        "print([l for l in maps.splitlines() if 'libmpi' in l or 'libopen-' in l or 'libpmix' in l], 'mpi4py' in sys.modules)"
    )
    assert python("-c", code, check=True).stdout.strip() == "[] False"


def test_the_module_needs_no_mpi_library():
    core = pathlib.Path(rs._core.__file__)
    needed = subprocess.run(["readelf", "-d", core], check=True, capture_output=True, text=True).stdout
    assert "NEEDED" in needed and "mpi" not in needed.lower()
    assert "not found" not in subprocess.run(["ldd", core], check=True, capture_output=True, text=True).stdout


def test_it_is_typed():
    import ringsplat._core

    package = pathlib.Path(ringsplat._core.__file__).parent
    assert (package / "py.typed").exists() and (package / "_core.pyi").exists()
    stub = (package / "_core.pyi").read_text()
    for name in dir(ringsplat._core):
        if not name.startswith("_"):
            assert name in stub, f"{name} is not in _core.pyi"


def test_python_m_ringsplat_is_the_command_line(tmp_path):
    done = python("-m", "ringsplat", "render", HEAD, "-o", tmp_path / "a.png", "--size", 32)
    assert done.returncode == 0 and (tmp_path / "a.png").exists()
    assert python("-m", "ringsplat", "--version").stdout.startswith(f"ringsplat {rs.__version__}")
    bad = python("-m", "ringsplat", "render", "no.nrrd", "-o", tmp_path / "b.png")
    assert bad.returncode == 2 and "ringsplat: error: cannot open no.nrrd" in bad.stderr
