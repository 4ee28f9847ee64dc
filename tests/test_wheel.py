"""The built wheel in an empty environment: what a user gets, nothing of this checkout."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

# Where no build is cached it compiles the core, and it installs into an empty environment.
pytestmark = [pytest.mark.slow, pytest.mark.whole]

ROOT = Path(__file__).parents[1]


def readme_snippet() -> str:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    assert blocks, "README.md has no Python"
    return "\n".join(blocks)


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    maturin = shutil.which("maturin", path=Path(sys.executable).parent)
    assert maturin, "maturin is not installed beside this Python"
    build = [maturin, "build", "--release", "--locked", "--quiet", "--out", str(folder)]
    subprocess.run(build, cwd=ROOT, check=True, timeout=600)
    (wheel,) = folder.glob("*.whl")
    assert "cp311-abi3" in wheel.name
    assert wheel.stat().st_size < 5_000_000
    home = folder / "empty"
    venv.create(home, with_pip=True)
    scripts = "Scripts" if os.name == "nt" else "bin"
    python = home / scripts / "python"
    install = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel]
    subprocess.run(install, check=True, timeout=600)
    return python


def test_the_readme_runs_from_the_wheel(python: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [python, "-c", readme_snippet()],
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg", "PYTHONPATH": ""},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "mean_velocity" in done.stdout
    assert (tmp_path / "r.parquet").is_file()


def test_the_command_is_installed(python: Path, tmp_path: Path) -> None:
    command = [python.parent / "locosweep", "quantities", "mean_velocity"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "equations (5) and (6)" in done.stdout
