"""ROS 2 bags as columns of measured runs: which clock, drives between rows, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from locosweep.errors import DataFileError, InputError
from locosweep.files import bags
from locosweep.files.bags import read_bag
from locosweep.files.runs import load_runs

STATES, COMMANDS = "/joint_states", "/cmd"
FIELDS = {"drive": "/cmd.data[0]", "x": "/joint_states.position[1]"}
BEGIN = 1_700_000_000_000_000_000
"""Time of the first message, ns since 1970."""


@pytest.fixture
def writer() -> Any:
    """Return the library's writer and its messages, or skip."""
    reason = "rosbags is not installed (pip install '.[ros]')"
    return pytest.importorskip("rosbags.rosbag2", reason=reason)


def write(
    writer: Any, folder: Path, *, storage: str = "MCAP", stamped: bool = True, late: float = 0.0
) -> Path:
    """Write a bag of 30 joint states at 100 Hz, and commands 4 ms before every third."""
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    make = store.types
    plugin = writer.StoragePlugin[storage]
    with writer.Writer(folder, version=9, storage_plugin=plugin) as bag:
        of = {
            topic: bag.add_connection(topic, kind, typestore=store)
            for topic, kind in (
                (STATES, "sensor_msgs/msg/JointState"),
                (COMMANDS, "std_msgs/msg/Float64MultiArray"),
                ("/name", "std_msgs/msg/String"),
            )
        }

        def send(topic: str, when: float, message: Any) -> None:
            stamp = BEGIN + round(1e9 * when)
            bag.write(of[topic], stamp, store.serialize_cdr(message, message.__msgtype__))

        layout = make["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
        send("/name", 0.0, make["std_msgs/msg/String"](data="rig"))
        for i in range(30):
            when = 0.01 * i
            if i % 3 == 1:
                values = np.array([0.1 * i])
                command = make["std_msgs/msg/Float64MultiArray"](layout=layout, data=values)
                send(COMMANDS, when - 0.004, command)
            stamp = BEGIN + round(1e9 * when)
            time = make["builtin_interfaces/msg/Time"](
                sec=stamp // 10**9 if stamped else 0, nanosec=stamp % 10**9 if stamped else 0
            )
            state = make["sensor_msgs/msg/JointState"](
                header=make["std_msgs/msg/Header"](stamp=time, frame_id=""),
                name=["a", "b"],
                position=np.array([9.0, 0.001 * i]),
                velocity=np.array([9.0, 0.1 + 0.001 * i]),
                effort=np.array([]),
            )
            send(STATES, when + late, state)
    return folder


def of_folder(folder: Path, suffix: str) -> Path:
    """Return the one file of a bag with an ending."""
    (found,) = folder.glob(f"*{suffix}")
    return found


@pytest.mark.parametrize(("storage", "suffix"), [("MCAP", ".mcap"), ("SQLITE3", ".db3")])
def test_a_bag_is_read_from_its_file_and_from_its_folder(
    writer: Any, tmp_path: Path, storage: str, suffix: str
) -> None:
    folder = write(writer, tmp_path / "bag", storage=storage)
    for path in (folder, of_folder(folder, suffix)):
        (run,), notices = load_runs(path, {**FIELDS, "v": "/joint_states.velocity[1]"})
        assert notices == []
        # Rows before the first command, of which the drive is not known, are left out.
        assert run.t == pytest.approx(0.01 * np.arange(29), abs=1e-9)
        assert run.channels["x"] == pytest.approx(0.001 * np.arange(1, 30))
        assert run.channels["v"] == pytest.approx(0.1 + 0.001 * np.arange(1, 30))


def test_the_drive_of_a_row_is_the_mean_of_what_holds_until_the_next(
    writer: Any, tmp_path: Path
) -> None:
    (run,), _ = load_runs(write(writer, tmp_path / "bag"), FIELDS)
    # A command lies 4 ms before rows 1, 4, ... of the bag, in the steps from 0, 3, ...
    assert run.drive[:2].tolist() == [0.1, 0.1]
    assert run.drive[2] == pytest.approx(0.6 * 0.1 + 0.4 * 0.4)
    assert run.drive[3:5].tolist() == pytest.approx([0.4, 0.4], abs=0.0)


def test_without_a_header_in_every_topic_the_times_of_recording_count(
    writer: Any, tmp_path: Path
) -> None:
    # Commands have no header: by those of states, recorded 2 ms later, all would be too early.
    folder = write(writer, tmp_path / "bag", late=0.002)
    (run,), _ = load_runs(folder, FIELDS)
    assert run.drive[2] == pytest.approx(0.4 * 0.1 + 0.6 * 0.4)
    both = {"drive": "/joint_states.velocity[1]", "x": "/joint_states.position[1]"}
    for stamped in (True, False):
        folder = write(writer, tmp_path / f"{stamped}", stamped=stamped, late=0.002)
        (run,), _ = load_runs(folder, both)
        assert run.t.size == 30


def test_units_are_those_of_our_columns(writer: Any, tmp_path: Path) -> None:
    (run,), _ = load_runs(write(writer, tmp_path / "bag"), FIELDS, {"x": "mm"})
    assert run.channels["x"][-1] == pytest.approx(29e-6)


@pytest.mark.parametrize(
    ("fields", "error", "said"),
    [
        ({"x": FIELDS["x"]}, InputError, "no topic is given for drive"),
        ({**FIELDS, "x": "joint_states"}, InputError, "x=joint_states: allowed is /topic.field"),
        ({**FIELDS, "y": "/a.b"}, InputError, "unknown column 'y'"),
        ({**FIELDS, "x": "/joints.position[0]"}, DataFileError,
         "no topic /joints: there are /cmd, /joint_states, /name"),
        ({**FIELDS, "x": "/joint_states.angle[0]"}, DataFileError,
         "no field angle of angle[0]: there are header, name, position, velocity, effort"),
        ({**FIELDS, "x": "/joint_states.position[2]"}, DataFileError,
         "position[2]: no element 2, there are 2 of them"),
        ({**FIELDS, "x": "/joint_states.position"}, DataFileError, "position is no number"),
        ({**FIELDS, "x": "/name.data"}, DataFileError, "data is no number"),
    ],
)  # fmt: skip
def test_what_is_not_there_is_refused_in_one_line(
    writer: Any, tmp_path: Path, fields: dict[str, str], error: type[Exception], said: str
) -> None:
    path = write(writer, tmp_path / "bag")
    with pytest.raises(error) as raised:
        read_bag(path, fields)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_file_that_is_no_bag_is_refused(writer: Any, tmp_path: Path) -> None:
    del writer
    for name in ("text.mcap", "text.db3"):
        path = tmp_path / name
        path.write_text("t,drive,x\n")
        with pytest.raises(DataFileError, match="not a readable bag"):
            read_bag(path, FIELDS)
    with pytest.raises(DataFileError, match="no such file"):
        read_bag(tmp_path / "none.mcap", FIELDS)


def test_without_the_extra_the_error_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "rosbags.highlevel", None)
    with pytest.raises(InputError, match=r"pip install '\.\[ros\]'"):
        read_bag(tmp_path / "run.mcap", FIELDS)


def test_bags_are_told_by_their_ending_or_their_folder(tmp_path: Path) -> None:
    assert bags.is_bag(Path("run.mcap"))
    assert bags.is_bag(Path("run.db3"))
    assert not bags.is_bag(Path("runs.csv"))
    assert not bags.is_bag(tmp_path)
    (tmp_path / "metadata.yaml").touch()
    assert bags.is_bag(tmp_path)


def test_a_command_that_is_none_holds_nothing() -> None:
    """Controllers send NaN before their first command, and between."""
    times = np.array([0.0, 15.0, 35.0, 55.0, 75.0])
    values = np.array([np.nan, 1.0, 2.0, np.nan, 4.0])
    found = bags._held(times, values, np.arange(20.0, 90.0, 10.0))
    np.testing.assert_allclose(found, [1.0, 1.5, 2.0, 2.0, 2.0, 3.0, 4.0])
