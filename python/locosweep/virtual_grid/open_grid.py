"""Open a sweep as a virtual grid."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.errors import InputError
from locosweep.run_folder.written_spec import cells_of_spec
from locosweep.specs.sweep import Spec

if TYPE_CHECKING:
    import os

    import xarray as xr


def open_grid(spec: Spec | str | os.PathLike[str]) -> xr.Dataset:
    """Open a sweep as an xarray Dataset that computes what is taken from it; nothing is stored.

    Parameters
    ----------
    spec : Spec or path-like
        The sweep, or a sweep file. Its grid may be of any size.

    Returns
    -------
    xarray.Dataset
        Each output and its statuses ``NAME_status``, with units. Values are computed when
        they are needed: by ``.values``, ``.load()``, or in a Dask graph after ``.chunk()``.

    Raises
    ------
    InputError
        xarray is not there; whatever `sweep` refuses; a part larger than the memory allows.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.specs.span import Span
    >>> axes = (("mu_static", Span(0.2, 0.9, 10_000)), ("slope_deg", Span(0, 20, 10_000)),
    ...         ("mass", Span(0.1, 1.0, 1000)))
    >>> spec = ls.Spec(("mean_velocity",), axes, (("mu_coulomb", 0.3), ("segments", 4)))
    >>> grid = ls.open_grid(spec)
    >>> grid["mean_velocity"].size
    100000000000
    >>> cut = grid["mean_velocity"].isel(mass=500, slope_deg=0)
    >>> round(cut.sel(mu_static=0.5, method="nearest").item(), 3)
    0.086
    """
    try:
        from locosweep.virtual_grid.backend import dataset
    except ModuleNotFoundError:
        raise InputError("open_grid needs xarray: pip install '.[xarray]' in a clone") from None

    return dataset(cells_of_spec(spec if isinstance(spec, Spec) else Spec.load(spec)))
