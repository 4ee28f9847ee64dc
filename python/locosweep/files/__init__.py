"""Files in and out: robot files, measured columns, results, folders."""

from locosweep.files.robot import Robot as Robot
from locosweep.files.robot import load_robot as load_robot
