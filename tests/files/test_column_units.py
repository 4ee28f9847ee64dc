"""Units of columns: their factors, and that they measure what the column does."""

import random
import subprocess
import sys

import pytest

from locosweep.errors import InputError
from locosweep.files.runs import load_runs
from locosweep.files.units import DRIVES, factor, is_unit
from locosweep.friction_fit import read_friction
from locosweep.intake.log import read_log


@pytest.mark.parametrize(
    ("column", "unit", "allowed", "value"),
    [
        ("x", "m", ("m", "rad"), 1.0),
        ("x", "mm", ("m", "rad"), 1e-3),
        ("x", "inch", ("m",), 0.0254),
        ("x", "µm", ("m",), 1e-6),
        ("x", "deg", ("m", "rad"), 3.141592653589793 / 180.0),
        ("x", "°", ("rad",), 3.141592653589793 / 180.0),
        ("t", "ms", ("s",), 1e-3),
        ("t", "minute", ("s",), 60.0),
        ("v", "rpm", ("m/s", "rad/s"), 3.141592653589793 / 30.0),
        ("v", "mm/s", ("m/s", "rad/s"), 1e-3),
        ("force", "lbf", ("N", "N m"), 4.4482216152605),
        ("force", "Nm", ("N", "N m"), 1.0),
        ("force", "N·mm", ("N", "N m"), 1e-3),
        ("drive", "percent", DRIVES, 1e-2),
        ("drive", "%", DRIVES, 1e-2),
        ("drive", "mA", DRIVES, 1e-3),
        ("drive", "1", DRIVES, 1.0),
        ("drive", "bar", DRIVES, 1e5),
        ("slope_deg", "deg", ("deg",), 1.0),
        ("slope_deg", "rad", ("deg",), 180.0 / 3.141592653589793),
    ],
)
def test_factors(column, unit, allowed, value):
    assert factor(column, unit, allowed) == pytest.approx(value, rel=1e-13)


@pytest.mark.parametrize(
    ("column", "unit", "allowed"),
    [
        ("x", "kN", ("m", "rad")),
        ("x", "s", ("m", "rad")),
        ("x", "deg", ("m",)),
        ("x", "mm", ("rad",)),
        ("v", "mm", ("m/s",)),
        ("v", "Hz", ("rad/s",)),
        ("t", "1", ("s",)),
        ("drive", "s", DRIVES),
        ("drive", "mm", DRIVES),
        ("slope_deg", "percent", ("deg",)),
        ("slope_deg", "m", ("deg",)),
        ("force", "kg", ("N",)),
        ("x", "degC", ("m", "rad")),
    ],
)
def test_a_unit_of_something_else_is_refused(column, unit, allowed):
    words = f"unit of {column}: {unit} measures something else, allowed is a unit of {allowed[0]}"
    with pytest.raises(InputError, match=words):
        factor(column, unit, allowed)


@pytest.mark.parametrize("text", ["mmm", "9**9**9", "m**99999", "", "__import__('os')", "a" * 99])
def test_what_is_no_unit(text):
    assert not is_unit(text)
    with pytest.raises(InputError, match="unknown unit"):
        factor("x", text, ["m"])


def test_texts_of_every_kind_are_units_or_none():
    chance = random.Random(1)  # noqa: S311
    names = ["m", "mm", "KPH", "ECC", "Tj", "AU", "if", "is", "lambda", "pi", "None"]
    ends = ["", "^2", "**2", "-1", "*-2", "2"]
    for _ in range(500):
        count = chance.choice([1, 2, 3])
        parts = (chance.choice(names) + chance.choice(ends) for _ in range(count))
        assert is_unit(chance.choice([" ", "*", "/", " / "]).join(parts)) in (True, False)


def test_pint_is_imported_only_where_a_unit_differs():
    script = (
        "import sys; from locosweep.files.units import factor; factor('x', 'm', ['m']); "
        "import locosweep.files.runs; assert 'pint' not in sys.modules; "
        "factor('x', 'mm', ['m']); assert 'pint' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def _measured(folder):
    rows = [f"{0.01 * i:.2f},1.0,{0.001 * i * i:.6f},1.0" for i in range(40)]
    path = folder / "bench.csv"
    path.write_text("\n".join(["t,drive,x,force", *rows, ""]))
    return path


@pytest.mark.parametrize("read", [load_runs, read_friction, read_log])
def test_a_unit_of_a_column_that_is_not_there_is_refused(read, tmp_path):
    path = _measured(tmp_path)
    read(path, units={"x": "mm"})
    with pytest.raises(InputError, match=r"^unit: .*bench\.csv has no column v: there are t, "):
        read(path, units={"x": "mm", "v": "mm/s"})


def test_a_unit_counts_for_the_files_that_have_the_column(tmp_path):
    files = [_measured(tmp_path), tmp_path / "speed.csv"]
    files[1].write_text(files[0].read_text().replace("force", "v", 1))
    load_runs(files, units={"v": "mm/s"})
    with pytest.raises(InputError, match=r"^unit: none of 2 files has a column power: there are "):
        load_runs(files, units={"power": "mW"})
