from _typeshed import Incomplete, SupportsGetItem
from typing import Any, SupportsFloat, SupportsIndex, final

__all__ = ["CancelToken", "Parameter", "Quantity", "Sweep", "file_choices", "file_keys", "parameters", "quantities", "reductions", "simd_level", "simd_levels", "statuses", "threads_to_use", "version"]

@final
class CancelToken:
    """
    Stops a running sweep from another thread.
    """
    def __new__(cls, /) -> CancelToken: ...
    def cancel(self, /) -> None:
        """
        Ask the sweep that holds this token to stop.
        """
    @property
    def done(self, /) -> int:
        """
        Evaluations finished so far.
        """

@final
class Parameter:
    """
    A parameter: what it is called, measured in, and which values it may take.
    """
    def __repr__(self, /) -> str: ...
    @property
    def allowed(self, /) -> str:
        """
        What is allowed, in words.
        """
    def check(self, /, value: SupportsFloat | SupportsIndex) -> float:
        """
        Raise InputError where the value is not allowed.
        """
    @property
    def default(self, /) -> float | None:
        """
        None where the user must give it.
        """
    @property
    def file_key(self, /) -> tuple[str, str] | None:
        """
        Table and key in a robot file, where it has one.
        """
    @property
    def integer(self, /) -> bool: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def range(self, /) -> tuple[float, float]:
        """
        Smallest and largest value allowed.
        """
    @property
    def symbol(self, /) -> str: ...
    @property
    def unit(self, /) -> str: ...

@final
class Quantity:
    """
    A quantity that a sweep can compute.
    """
    def __repr__(self, /) -> str: ...
    @property
    def formula(self, /) -> str:
        """
        TeX, in the symbols of the parameters.
        """
    @property
    def integer(self, /) -> bool: ...
    @property
    def limits(self, /) -> str: ...
    @property
    def meaning(self, /) -> str: ...
    @property
    def name(self, /) -> str: ...
    @property
    def parameters(self, /) -> list[Parameter]: ...
    @property
    def source(self, /) -> str: ...
    @property
    def symbol(self, /) -> str: ...
    @property
    def unit(self, /) -> str: ...

@final
class Sweep:
    """
    A checked grid and what to compute on it.
    """
    def __new__(cls, /, axes: SupportsGetItem[int, tuple[str, Incomplete]], fixed: SupportsGetItem[int, tuple[str, SupportsFloat | SupportsIndex]], requests: SupportsGetItem[int, tuple[str, str | None, SupportsFloat | SupportsIndex | None]], over: str | None = None) -> Sweep:
        """
        `requests` are (quantity, reduction or None, q or None).
        """
    @property
    def axes(self, /) -> list[str]:
        """
        Names of the axes of the result, in order.
        """
    @property
    def cells(self, /) -> int:
        """
        Cells of each result.
        """
    @property
    def evaluations(self, /) -> int:
        """
        How often a formula is evaluated.
        """
    @property
    def fixed(self, /) -> list[tuple[str, float]]:
        """
        Name and value of every parameter that is not an axis.
        """
    def run(self, /, outputs: SupportsGetItem[int, tuple[SupportsIndex, Any]], threads: SupportsIndex, chunk: SupportsIndex | None = None, progress: Any | None = None, token: CancelToken | None = None, level: str | None = None, fresh: bool = False) -> None:
        """
        Fill arrays: each output is (number of the request, array). An array of
        uint8 receives status codes. `fresh`: the arrays were never written to.
        """
    @property
    def shape(self, /) -> list[int]:
        """
        Shape of each result.
        """
    def working_bytes(self, /, threads: SupportsIndex) -> int:
        """
        Bytes needed beside the results.
        """

def file_choices() -> list[tuple[str, str, list[str]]]:
    """
    Table, key and allowed words of the keys of a robot file that take a word.
    """

def file_keys() -> list[Parameter]:
    """
    Keys of a robot file that are not parameters of the closed forms.
    """

def parameters() -> list[Parameter]:
    """
    All parameters of the closed forms.
    """

def quantities() -> list[Quantity]:
    """
    All quantities, in the order of their equations.
    """

def reductions() -> list[tuple[str, str]]:
    """
    Name and meaning of every reduction.
    """

def simd_level() -> str:
    """
    SIMD level in use.
    """

def simd_levels() -> list[str]:
    """
    SIMD levels that this machine runs, lowest first.
    """

def statuses() -> list[tuple[int, str, str]]:
    """
    Code, name and sentence of every status.
    """

def threads_to_use(asked: SupportsIndex | None = None) -> int:
    """
    Threads that a call would use.
    """

def version() -> str:
    """
    Version of the package.
    """
