"""How much a search tries: few numbers, each with what it is and why."""

from __future__ import annotations

import ast
from pathlib import Path

from locosweep.diagnosis.select import effort

MOST = 10


def test_few_numbers_say_how_much_is_tried() -> None:
    body = ast.parse(Path(effort.__file__).read_text(encoding="utf-8")).body
    numbers = [i for i, node in enumerate(body) if isinstance(node, ast.Assign)]
    assert 0 < len(numbers) <= MOST
    for i in numbers:
        said = body[i + 1]
        assert isinstance(said, ast.Expr)
        assert isinstance(said.value, ast.Constant)
    for name in (n for n in vars(effort) if n.isupper()):
        assert getattr(effort, name) > 0
