"""Write exp_functions.csv: the functions of viscous motion, correctly rounded.

Run from this directory: python make_exp_functions.py > exp_functions.csv
"""

import random
import sys

import mpmath as mp

mp.mp.dps = 60
ROWS = 400


def arguments() -> list[float]:
    """Seams of the implementation, all magnitudes, and the range of exp."""
    rng = random.Random(1)  # noqa: S311
    ln2 = 0.6931471805599453
    seams = [0.0, 1.0, 0.25, -0.25, 0.5 * ln2, -0.5 * ln2, 700.0, -700.0, 37.0, -37.0]
    x = [s * f for s in seams for f in (1.0, 1.0 - 2.0**-52, 1.0 + 2.0**-51)]
    x += [s * 10.0**e for e in (-300, -160, -100, -17, -16, -12, -8, -4, -2) for s in (-1.0, 1.0)]
    x += [10.0**e for e in (2, 3, 5, 8, 12, 100)]
    x += [2.0**-k - 1.0 for k in range(1, 54, 4)]
    x += [(k + 0.5) * ln2 for k in range(-1000, 1000, 50)]
    x += [10.0 ** rng.uniform(-20, 9) for _ in range(80)]
    x += [rng.uniform(-1, 1) for _ in range(80)]
    x += [rng.uniform(0, 3) for _ in range(40)]
    x = sorted(set(x))
    while len(x) < ROWS:
        x = sorted({*x, rng.uniform(-700, 700)})
    return x


def number(value: mp.mpf) -> str:
    """Return the nearest double in the fewest digits."""
    return repr(float(value))


def row(x: float) -> str:
    """One line; empty where a function does not take x."""
    t = mp.mpf(x)
    cells = [repr(x)]
    cells.append(number(mp.exp(t)) if abs(x) <= 700 else "")
    # 60 digits do not survive the cancellation near zero: the series does.
    with mp.workdps(1000 if 0 < abs(x) < 1e-20 else 200):
        t = mp.mpf(x)
        if x >= 0:
            cells.append(number((t + mp.expm1(-t)) / t**2 if x else mp.mpf(0.5)))
            cells.append(number(-mp.expm1(-t) / t if x else mp.mpf(1)))
        else:
            cells += ["", ""]
        if x > -1:
            cells.append(number(mp.log1p(t) / t if x else mp.mpf(1)))
            cells.append(number((t - mp.log1p(t)) / t**2 if x else mp.mpf(0.5)))
        else:
            cells += ["", ""]
    return ",".join(cells)


if __name__ == "__main__":
    lines = ["x,exp,path_factor,speed_factor,log_factor,log_path_factor"]
    lines += [row(x) for x in arguments()]
    sys.stdout.write("\n".join(lines) + "\n")
