"""Formulas of the registry: numbers of an effect that follow from the sizes of a rig."""

from __future__ import annotations

import ast
import math
import operator
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    Sizes = Mapping[str, Any]
    Node = Callable[[Sizes], Any]


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "min": np.minimum,
    "max": np.maximum,
    "sqrt": np.sqrt,
    "degrees": np.degrees,
    "critical": lambda stiffness, mass: 2.0 * np.sqrt(stiffness * mass),
    "both": lambda x: np.concatenate([-x, x]),
    "geomspace": lambda low, high, count: np.geomspace(low, high, int(count)),
}
_CONSTANTS = {"pi": math.pi, "inf": math.inf}
_OPERATORS: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.LtE: operator.le,
}


def _node(node: ast.AST, text: str) -> Node:
    """Return a function of the sizes for a node; operations keep the order of the text."""
    match node:
        case ast.Constant(value=int() | float() as value):
            constant = float(value)
            return lambda _: constant
        case ast.Name(id=name) if name in _CONSTANTS:
            known = _CONSTANTS[name]
            return lambda _: known
        case ast.Name(id=name):
            return lambda sizes: sizes[name]
        case ast.List(elts=elements):
            parts = [_node(element, text) for element in elements]
            return lambda sizes: np.array([part(sizes) for part in parts])
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _node(operand, text)
            return lambda sizes: -inner(sizes)
        case (
            ast.BinOp(left=left, op=op, right=right)
            | ast.Compare(left=left, ops=[op], comparators=[right])
        ) if type(op) in _OPERATORS:
            apply, one, other = _OPERATORS[type(op)], _node(left, text), _node(right, text)
            return lambda sizes: apply(one(sizes), other(sizes))
        case ast.Call(func=ast.Name(id=name), args=given, keywords=[]) if name in _FUNCTIONS:
            function, inputs = _FUNCTIONS[name], [_node(argument, text) for argument in given]
            return lambda sizes: function(*(argument(sizes) for argument in inputs))
    raise ValueError(f"formula {text!r}: {ast.unparse(node)!r} is not in the vocabulary")


@cache
def _parsed(text: str) -> Node:
    return _node(ast.parse(text, mode="eval").body, text)


def numbers(text: str, sizes: Sizes) -> np.ndarray:
    """Return what a formula of the registry gives, as a one-dimensional array.

    The vocabulary stands in `rust/core/physics/effects/row.rs`; `sizes` gives the numbers that
    its names stand for, SI. A name that is none of them is a KeyError, a formula beyond the
    vocabulary a ValueError.

    Examples
    --------
    >>> from locosweep.diagnosis.effects.formula import numbers
    >>> numbers("travel * [0.25, 0.5]", {"travel": 2.0})
    array([0.5, 1. ])
    """
    return np.atleast_1d(_parsed(text)(sizes))


def number(text: str, sizes: Sizes) -> float:
    """Return the single number that a formula gives.

    Examples
    --------
    >>> from locosweep.diagnosis.effects.formula import number
    >>> number("-min(force / speed, 4)", {"force": 1.0, "speed": 0.5})
    -2.0
    """
    return float(_parsed(text)(sizes))
