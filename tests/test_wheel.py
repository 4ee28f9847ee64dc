"""The built wheel in empty environments of every Python here, and a clone that pip installs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from email.parser import Parser
from pathlib import Path

import pytest

# Where no build is cached it compiles the core, and it installs into empty environments.
pytestmark = [pytest.mark.slow, pytest.mark.whole]

ROOT = Path(__file__).parents[1]
OLDEST = 11
"""Python 3.11, as in pyproject.toml."""
# Nothing of this checkout, and no screen.
CLEAN = {**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": ""}
SWEEP = (
    "import locosweep as ls; r = ls.sweep('mean_velocity', mu_static=0.5, mu_coulomb=0.3, "
    "segments=[3, 4, 5]); print(ls.__version__, ls.__file__, r.values.tolist())"
)


def minor_of(python: Path) -> int | None:
    """Return the minor version of a Python 3, or None where it is none that runs."""
    ask = "import sys, venv, ensurepip; print(*sys.version_info[:2], sys.implementation.name)"
    done = subprocess.run([python, "-c", ask], capture_output=True, text=True, check=False)
    major, minor, kind = done.stdout.split() if done.returncode == 0 else ("0", "0", "")
    return int(minor) if major == "3" and kind == "cpython" else None


def pythons() -> dict[str, Path]:
    """Return one Python for each version that is here and that the wheel is for."""
    versions = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    found = [Path(sys.executable), *sorted(versions.glob("3.*/bin/python"))]
    found += [Path(p) for n in range(OLDEST, 20) if (p := shutil.which(f"python3.{n}"))]
    known: dict[str, Path] = {}
    for python in found:
        minor = minor_of(python)
        if minor is not None and minor >= OLDEST:
            known.setdefault(f"3.{minor}", python)
    return known


PYTHONS = pythons()


def readme_snippet() -> str:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert blocks, "README.md has no Python"
    return "\n".join(blocks)


def run(*command: str | Path, cwd: Path, timeout: int = 600) -> str:
    done = subprocess.run(
        command, cwd=cwd, env=CLEAN, capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    maturin = shutil.which("maturin", path=Path(sys.executable).parent)
    assert maturin, "maturin is not installed beside this Python"
    build = [maturin, "build", "--release", "--locked", "--strip", "--quiet", "--out", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, timeout=1200)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module", params=PYTHONS)
def python(
    request: pytest.FixtureRequest, wheel: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Return the Python of an environment that has the wheel and what it needs, nothing else."""
    home = tmp_path_factory.mktemp("empty")
    run(PYTHONS[request.param], "-m", "venv", home, cwd=home)
    python = home / ("Scripts" if os.name == "nt" else "bin") / "python"
    run(python, "-m", "pip", "install", "--disable-pip-version-check", wheel, cwd=home)
    return python


def test_the_wheel_serves_all_pythons_and_says_what_it_is(wheel: Path) -> None:
    assert "cp311-abi3" in wheel.name
    assert wheel.stat().st_size < 5_000_000
    with zipfile.ZipFile(wheel) as packed:
        names = packed.namelist()
        (metadata,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        said = Parser().parsestr(packed.read(metadata).decode())
    assert said["License-Expression"] == "Apache-2.0 OR MIT"
    for file in ("LICENSE-APACHE", "LICENSE-MIT", "THIRD-PARTY.md"):
        assert file in said.get_all("License-File", [])
        assert any(name.endswith(f"/licenses/{file}") for name in names)
    assert said["Requires-Python"] == f">=3.{OLDEST}"
    assert said.get_payload().startswith("# locosweep")
    assert {"locosweep/py.typed", "locosweep/_core.pyi"} <= set(names)
    top = {name.split("/")[0].split("-")[0] for name in names}
    assert top == {"locosweep"}


def test_the_readme_runs_from_the_wheel(python: Path, tmp_path: Path) -> None:
    assert "mean_velocity" in run(python, "-c", readme_snippet(), cwd=tmp_path)
    assert (tmp_path / "r.parquet").is_file()


def test_a_sweep_runs_from_the_wheel(python: Path, tmp_path: Path) -> None:
    said = run(python, "-c", SWEEP, cwd=tmp_path)
    assert str(python.parents[1]) in said
    assert said.count("0.0") >= 3


def test_the_command_is_installed(python: Path, tmp_path: Path) -> None:
    command = python.parent / "locosweep"
    assert "diagnose" in run(command, "--help", cwd=tmp_path)
    told = run(command, "quantities", "mean_velocity", cwd=tmp_path)
    assert "equations (5) and (6)" in told


# Of one Python: the core is compiled anew for each that asks for it.
@pytest.mark.parametrize("python", [next(iter(PYTHONS))], indirect=True)
def test_pip_installs_a_clone(python: Path, tmp_path: Path) -> None:
    target = tmp_path / "site"
    install = ("-m", "pip", "install", "--disable-pip-version-check", "--no-deps")
    run(python, *install, "--target", target, ROOT, cwd=tmp_path, timeout=1200)
    # Before the installed one on the path, so that what is imported is the clone's.
    lead = f"import sys; sys.path.insert(0, {str(target)!r}); {SWEEP}"
    assert str(target) in run(python, "-c", lead, cwd=tmp_path)
