"""Arrays of a run as Zarr v3: their metadata as text, and a chunk as the bytes of its file.

Codecs are ``bytes`` (little endian) and ``crc32c``, with ``zstd`` between for statuses, which
repeat; values hardly shrink, and compressing them would be slower than a disk. Fill values, NaN
and 255, mean *not computed*.
"""

from __future__ import annotations

import importlib
import struct
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import InputError
from locosweep.registry import parameter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.run_folder.cells import Cells
    from locosweep.run_folder.plan import Plan

NOT_COMPUTED = 255
"""Status of a cell that no chunk holds yet."""
_LEVEL = 1
STORE = "data.zarr"
"""Folder of the arrays within a run."""


def need(module: str, extra: str = "runs") -> Any:
    """Import a package of an extra."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        name = module.partition(".")[0]
        raise InputError(f"run folders need {name}: pip install '.[{extra}]' in a clone") from None


def array_names(cells: Cells) -> list[str]:
    """Names of the arrays of a chunk in order: each output and its statuses."""
    return [name for o in cells.outputs for name in (o.name, f"{o.name}_status")]


def metadata(cells: Cells, plan: Plan) -> dict[str, bytes]:
    """Return all files of an empty store by path: metadata and coordinate axes."""
    zarr = need("zarr")
    files: dict[str, Any] = {}
    memory = zarr.storage.MemoryStore(files)
    dims = list(cells.axes)
    # Chunks in one folder: one fsync for all of a batch.
    shared: dict[str, Any] = {
        "store": memory, "dimension_names": dims,
        "chunk_key_encoding": {"name": "default", "separator": "."},
    }  # fmt: skip
    crc = zarr.codecs.Crc32cCodec()
    attributes = {"how": cells.how} if cells.how else {}
    # JSON has no infinity.
    attributes["fixed"] = {name: repr(float(value)) for name, value in cells.fixed.items()}
    zarr.create_group(memory, attributes=attributes)
    for output in cells.outputs:
        zarr.create_array(
            name=output.name, shape=plan.shape, chunks=plan.chunk, dtype=cells.dtype,
            fill_value=np.nan, compressors=[crc],
            attributes={"units": output.unit, "long_name": output.label}, **shared,
        )  # fmt: skip
        zarr.create_array(
            name=f"{output.name}_status", shape=plan.shape, chunks=plan.chunk, dtype="uint8",
            fill_value=NOT_COMPUTED, compressors=[zarr.codecs.ZstdCodec(level=_LEVEL), crc],
            attributes={"units": "1", "long_name": f"status of {output.label}"}, **shared,
        )  # fmt: skip
    for name, axis in cells.axes.items():
        record = parameter(name)
        array = zarr.create_array(
            name=name, shape=axis.shape, chunks=axis.shape, dtype="float64", fill_value=np.nan,
            compressors=[crc], attributes={"units": record.unit, "long_name": record.meaning},
            **(shared | {"dimension_names": [name]}),
        )  # fmt: skip
        array[:] = axis
    with warnings.catch_warnings():
        # It lies within the group's own file, where readers that do not know it pass it over.
        warnings.filterwarnings("ignore", "Consolidated metadata")
        zarr.consolidate_metadata(memory)
    return {key: files[key].to_bytes() for key in sorted(files)}


def encode(
    values: NDArray[Any], chunk: tuple[int, ...], *, status: bool
) -> list[bytes | memoryview]:
    """Return the parts of a chunk's file; a chunk at an end is filled up to its full shape."""
    if values.shape != chunk:
        fill = NOT_COMPUTED if status else np.nan
        whole = np.full(chunk, fill, values.dtype)
        whole[tuple(slice(0, n) for n in values.shape)] = values
        values = whole
    little = np.ascontiguousarray(values, values.dtype.newbyteorder("<"))
    raw: Any = little.reshape(-1).view(np.uint8)
    if status:
        raw = np.frombuffer(need("numcodecs").Zstd(_LEVEL).encode(raw), np.uint8)
    check = struct.pack("<I", need("google_crc32c").value(raw))
    return [memoryview(raw), check]
