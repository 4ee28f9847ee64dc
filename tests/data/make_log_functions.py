"""Write log_functions.csv: logarithms, powers and sines, correctly rounded.

Run from this directory: python make_log_functions.py > log_functions.csv

Each line has a function, its arguments (the second is 0 but for powers) and
its value.
"""

import random
import sys

import mpmath as mp

mp.mp.dps = 400


def magnitudes(rng: random.Random) -> list[float]:
    """Positive numbers of all sizes, crowded where the exponent changes."""
    x = [5e-324, 2.2250738585072014e-308, 1.7976931348623157e308, 3e-310]
    for seam in (0.5, 0.7071067811865476, 1.0, 1.4142135623730951, 2.0, 3.0):
        x += [seam * (1.0 + k * 2.0**-52) for k in (-3, -1, 0, 1, 2, 5)]
        x += [seam * (1.0 + k * 10.0**-e) for k in (-1, 1) for e in (1, 2, 4, 8, 12)]
    x += [10.0 ** rng.uniform(-300, 300) for _ in range(60)]
    x += [10.0 ** rng.uniform(-12, 8) for _ in range(60)]
    x += [rng.uniform(0.5, 2.0) for _ in range(80)]
    return sorted(set(x))


def shifted(rng: random.Random) -> list[float]:
    """Arguments of ln(1 + x): both sides of 0, and close to -1."""
    x = [s * 10.0**e for e in (-320, -300, -100, -20, -16, -12, -8, -4, -2) for s in (-1, 1)]
    x += [2.0**-k - 1.0 for k in range(1, 54, 3)]
    x += [2.0**k - 1.0 + j * 2.0 ** (k - 53) for k in range(1, 70, 4) for j in (-1, 0, 1)]
    for seam in (-0.29289321881345254, 0.41421356237309503, 1.8284271247461900):
        x += [seam * (1.0 + k * 2.0**-52) for k in (-2, -1, 0, 1, 2)]
    x += [10.0 ** rng.uniform(-18, 18) for _ in range(80)]
    x += [rng.uniform(-1, 1) for _ in range(100)]
    x += [rng.uniform(0, 3) for _ in range(60)]
    return sorted(set(x))


def turns(rng: random.Random) -> list[float]:
    """Multiples of an eighth and their neighbours, and random numbers."""
    x = [k / 8 for k in range(-17, 18)]
    x += [k / 8 * (1.0 + j * 2.0**-52) for k in range(1, 18) for j in (-1, 1)]
    x += [s * 10.0**e for e in (-300, -20, -9, -5, -3) for s in (-1.0, 1.0)]
    x += [1e6, -1e6, 999999.9, 123456.78901, 1e9 + 0.123]
    x += [rng.uniform(-1, 1) for _ in range(150)]
    x += [rng.uniform(-1e6, 1e6) for _ in range(100)]
    return sorted(set(x))


def bases(rng: random.Random) -> list[tuple[float, float]]:
    """Pairs whose power stays within the range of doubles."""
    pairs = [(10.0 ** rng.uniform(-9, 3), rng.uniform(0.1, 4.0)) for _ in range(200)]
    pairs += [(rng.uniform(0.0, 2.0), rng.choice([0.5, 1.0, 1.5, 2.0, 3.0])) for _ in range(60)]
    pairs += [(10.0 ** rng.uniform(-70, 70), rng.uniform(-4.0, 4.0)) for _ in range(200)]
    return sorted(pairs)


def number(value: mp.mpf) -> str:
    """Return the nearest double in the fewest digits."""
    return repr(float(value))


if __name__ == "__main__":
    rng = random.Random(1)  # noqa: S311
    rows = [("ln", x, 0.0, mp.log(mp.mpf(x))) for x in magnitudes(rng)]
    rows += [("ln_1p", x, 0.0, mp.log(1 + mp.mpf(x))) for x in shifted(rng) if x > -1]
    for x in turns(rng):
        rows.append(("sin_turns", x, 0.0, mp.sinpi(2 * mp.mpf(x))))
        rows.append(("cos_turns", x, 0.0, mp.cospi(2 * mp.mpf(x))))
    rows += [("power", x, p, mp.mpf(x) ** mp.mpf(p)) for x, p in bases(rng)]
    lines = ["function,x,p,value"]
    lines += [f"{name},{x!r},{p!r},{number(value)}" for name, x, p, value in rows]
    sys.stdout.write("\n".join(lines) + "\n")
