"""Drives a server by the unmodified client `unifr-api-epuck`; run as a program: PORT COMMANDS IMAGES_EVERY.

Prints one JSON object: what it read, beside what it asked for. The modules that the client imports and does
not declare (torch and more, for pictures of its own) are stubs.
"""

import json
import sys
import tempfile
import types
from typing import Any


def _stub(name: str, **values: Any) -> Any:
    module = types.ModuleType(name)
    module.__dict__.update(values)
    sys.modules[name] = module
    return module


class _SocketClient:
    def __init__(self, *args: Any, **options: Any) -> None:
        pass

    def event(self, handler: Any = None, *args: Any) -> Any:
        return handler if handler is not None else lambda function: function

    def on(self, *args: Any, **options: Any) -> Any:
        return lambda function: function


def client_class() -> Any:
    """The client's class for robots on a network."""
    _stub("torch")
    _stub("cv2", MORPH_RECT=0)
    _stub("socketio", Client=_SocketClient)
    _stub("unifr_api_epuck.epuck.models.helper", non_max_suppression=None, plot_detection=None)
    _stub("unifr_api_epuck.epuck.models.yolo", attempt_load=None)
    from unifr_api_epuck.epuck.epuck_wifi import WifiEpuck

    return WifiEpuck


def main(port: int, commands: int, images_every: int) -> None:
    """Reads and drives for so many commands."""
    kind = client_class()
    connect = kind._WifiEpuck__tcp_init

    def at_port(self: Any) -> Any:
        self.TCP_PORT = port
        return connect(self)

    kind._WifiEpuck__tcp_init = at_port
    robot = kind("127.0.0.1")
    robot.init_sensors()
    found: dict[str, Any] = {"asked": 0, "answered": 0, "images": 0, "steps": [], "proximity": [], "bad": 0}

    def exchange() -> None:
        found["asked"] += 1
        found["answered"] += bool(robot.go_on())

    with tempfile.TemporaryDirectory() as folder:
        for number in range(1, commands + 1):
            turn = 1.0 if number // 40 % 2 == 0 else -1.0
            robot.set_speed(turn, -turn)
            exchange()
            proximity = robot.get_prox()
            found["bad"] += not (len(proximity) == 8 and all(0 <= value <= 4095 for value in proximity))
            if number % 20 == 0:
                found["steps"].append(list(robot.get_motors_steps()))
                found["proximity"].append(list(proximity))
            if images_every and number % images_every == 0:
                robot.init_camera(folder)
                exchange()
                exchange()
                red, green, blue = robot.get_camera()
                found["images"] += bool(len(red) == 120 and len(green[0]) == 160 and blue.max() > 0)
                robot.disable_camera()
    found["battery"] = robot.get_battery_level()
    found["acceleration"] = list(robot.get_accelerometer_axes())
    found["tof"] = robot.get_tof()
    print(json.dumps(found), flush=True)
    robot.clean_up()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
