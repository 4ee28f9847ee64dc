"""Pictures of where the gap lies."""

from locosweep.diagnosis.report.figures_localization import _joined


def test_windows_that_touch_are_one():
    windows = [{"run": "a", "t0": 1.0, "t1": 2.0, "share": 0.2},
               {"run": "b", "t0": 2.0, "t1": 3.0, "share": 0.1},
               {"run": "a", "t0": 2.0, "t1": 3.0, "share": 0.3},
               {"run": "a", "t0": 4.0, "t1": 5.0, "share": 0.1}]  # fmt: skip
    assert _joined(windows) == [("a", 1.0, 3.0, 0.5), ("a", 4.0, 5.0, 0.1),
                                ("b", 2.0, 3.0, 0.1)]  # fmt: skip
