# SPDX-License-Identifier: BSD-3-Clause
"""Starting roslaunch, rviz and a virtual screen, and making sure that they end."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import threading
import time
from typing import IO, Any, Dict

Environment = Dict[str, str]
_reserved_ports: list[socket.socket] = []


def free_port() -> int:
    """Returns a TCP port on which nobody listens at present; other processes that ask here do not get it either."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = int(probe.getsockname()[1])
        # roslaunch listens on the port a second later. Meanwhile a flight that starts beside this one could choose the
        # same port and join the wrong master. The name in Linux's abstract namespace ends with this process.
        reservation = socket.socket(socket.AF_UNIX)
        try:
            reservation.bind("\0voxnav_ros_master_%d" % port)
        except OSError:
            reservation.close()
            continue
        _reserved_ports.append(reservation)
        return port


class Process:
    """A child process in a process group of its own; stop() ends the whole group.

    ends_with_this: the child, which calls end_with_parent(), ends when this process ends, even if that is killed.
    """

    def __init__(self, command: list[str], log_path: str | None = None,
                 env: Environment | None = None, ends_with_this: bool = False) -> None:
        self.command = command
        self._log: IO[str] | None = open(log_path, "w") if log_path else None
        self._process = subprocess.Popen(command, stdout=self._log or subprocess.DEVNULL, stderr=subprocess.STDOUT,
                                         env=env, stdin=subprocess.PIPE if ends_with_this else subprocess.DEVNULL,
                                         start_new_session=True)

    def is_running(self) -> bool:
        return self._process.poll() is None

    @property
    def exit_status(self) -> int | None:
        """Returns the status with which the process ended (below 0: the signal that ended it); None while it runs."""
        return self._process.poll()

    def stop(self, timeout_s: float = 20.0) -> None:
        for sig, patience in ((signal.SIGINT, timeout_s), (signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0)):
            try:
                os.killpg(self._process.pid, sig)
            except ProcessLookupError:
                break
            try:
                self._process.wait(patience)
                break
            except subprocess.TimeoutExpired:
                continue
        for stream in (self._log, self._process.stdin):
            if stream is not None:
                stream.close()

    def __enter__(self) -> Process:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def end_cleanly_when_terminated() -> None:
    """Makes SIGTERM end the program like Ctrl-C, so that the processes that it started are stopped too."""
    def end(number: int, _: object) -> None:
        raise SystemExit(128 + number)
    signal.signal(signal.SIGTERM, end)


def end_with_parent() -> None:
    """Makes this program end, as by SIGTERM, when the process that started it with ends_with_this=True has ended."""
    def wait() -> None:
        while os.read(0, 4096):  # nothing is written there: reading returns when the other end of the pipe is closed
            pass
        os.kill(os.getpid(), signal.SIGTERM)
    threading.Thread(target=wait, daemon=True).start()


def launch(launch_file: str, arguments: dict[str, Any], log_path: str) -> tuple[Process, Environment]:
    """Starts roslaunch on a private master. Returns (process, environment for further nodes)."""
    port = free_port()
    env = dict(os.environ, ROS_MASTER_URI="http://127.0.0.1:%d" % port, ROS_IP="127.0.0.1")
    for name in ("ROS_HOSTNAME", "ROS_NAMESPACE"):
        env.pop(name, None)
    command = ["roslaunch", "-p", str(port), "voxnav", launch_file]
    command += ["%s:=%s" % item for item in arguments.items()]
    return Process(command, log_path, env), env


def virtual_screen(size: str = "1600x1000x24") -> tuple[Process | None, str | None]:
    """Starts Xvfb. Returns (process, name of its display), or (None, None) if Xvfb is not installed."""
    if shutil.which("Xvfb") is None:
        return None, None
    for number in range(90, 130):
        if os.path.exists("/tmp/.X11-unix/X%d" % number) or os.path.exists("/tmp/.X%d-lock" % number):
            continue
        display = ":%d" % number
        screen = Process(["Xvfb", display, "-screen", "0", size, "-nolisten", "tcp"])
        deadline = time.monotonic() + 10.0
        while time.monotonic() < deadline and screen.is_running():
            if os.path.exists("/tmp/.X11-unix/X%d" % number):
                return screen, display
            time.sleep(0.05)
        screen.stop()
    return None, None


def screenshot(display: str, path: str) -> bool:
    """Takes a picture of a whole screen. Returns False if it could not be taken."""
    if shutil.which("import") is None:
        return False
    result = subprocess.run(["import", "-display", display, "-window", "root", path], timeout=60,
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return result.returncode == 0 and os.path.exists(path)
