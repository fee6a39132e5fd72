"""ROS 2 messages of a plan, made and serialised by `rosbags`; no ROS needed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.errors import MissingExtraError
from demospec.frames import FloatArray
from demospec.planning.exports._nav2 import occupancy
from demospec.planning.exports._request import ExportRequest
from demospec.scene import Disc

if TYPE_CHECKING:
    from demospec.planning._results import Zone

TOPICS = {
    "/plan": "nav_msgs/msg/Path",
    "/cost_map": "nav_msgs/msg/OccupancyGrid",
    "/objects": "visualization_msgs/msg/MarkerArray",
    "/scene": "sensor_msgs/msg/Image",
}
_COLOUR = (0.835, 0.369, 0.0)  # Okabe–Ito vermillion


def type_store() -> Any:
    """The message types of ROS 2 Humble."""
    try:
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise MissingExtraError("rosbags", "ros", "exporting ROS messages") from error
    return get_typestore(Stores.ROS2_HUMBLE)


class Messages:
    """Builds the messages of one request; times are whole nanoseconds from the start."""

    def __init__(self, request: ExportRequest) -> None:
        self.request = request
        self.store = type_store()

    def all(self) -> list[tuple[str, Any]]:
        """(topic, message) for every topic that the request can fill."""
        messages = [
            ("/plan", self.path()),
            ("/cost_map", self.grid()),
            ("/objects", self.markers()),
        ]
        if self.request.scene.picture is not None:
            messages.append(("/scene", self.image()))
        return messages

    def _new(self, name: str, **fields: Any) -> Any:
        return self.store.types[name](**fields)

    def _stamp(self, seconds: float = 0.0) -> Any:
        nanoseconds = round(seconds * 1e9)
        return self._new(
            "builtin_interfaces/msg/Time",
            sec=nanoseconds // 10**9,
            nanosec=nanoseconds % 10**9,
        )

    def _header(self, seconds: float = 0.0) -> Any:
        stamp = self._stamp(seconds)
        return self._new("std_msgs/msg/Header", stamp=stamp, frame_id=self.request.frame_id)

    def _point(self, x: float, y: float, z: float = 0.0) -> Any:
        return self._new("geometry_msgs/msg/Point", x=float(x), y=float(y), z=float(z))

    def _pose(self, x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Any:
        turn = self._new(
            "geometry_msgs/msg/Quaternion",
            x=0.0,
            y=0.0,
            z=float(np.sin(yaw / 2)),
            w=float(np.cos(yaw / 2)),
        )
        at = self._point(x, y, z)
        return self._new("geometry_msgs/msg/Pose", position=at, orientation=turn)

    def path(self) -> Any:
        """`nav_msgs/Path`: way-points with time stamps, each looking along the path."""
        t, points = self.request.timed_path()
        metres = self.request.frame.to_metres(points)
        ahead = np.diff(metres, axis=0)
        yaw = np.arctan2(ahead[:, 1], ahead[:, 0])
        yaw = np.concatenate([yaw, yaw[-1:]])
        poses = [
            self._new(
                "geometry_msgs/msg/PoseStamped",
                header=self._header(float(s)),
                pose=self._pose(x, y, 0.0, angle),
            )
            for s, (x, y), angle in zip(t, metres, yaw, strict=True)
        ]
        return self._new("nav_msgs/msg/Path", header=self._header(), poses=poses)

    def grid(self) -> Any:
        """`nav_msgs/OccupancyGrid`: the graded map; its first row is the bottom one."""
        where = self.request.cost_map
        rows, columns = where.shape
        x, y = self.request.corner
        info = self._new(
            "nav_msgs/msg/MapMetaData",
            map_load_time=self._stamp(),
            resolution=where.cell * self.request.scale_m,
            width=columns,
            height=rows,
            origin=self._pose(x, y),
        )
        data = np.ascontiguousarray(self.request.rows_upwards(occupancy(self.request))).ravel()
        return self._new("nav_msgs/msg/OccupancyGrid", header=self._header(), info=info, data=data)

    def markers(self) -> Any:
        """`visualization_msgs/MarkerArray`: outlines of the objects and of their zones."""
        made: list[Any] = []
        for zone in self.request.cost_map.zones:
            for rim in self._outlines(zone):
                metres = self.request.frame.to_metres(rim)
                made.append(self._strip(len(made), zone.object_id, metres))
        return self._new("visualization_msgs/msg/MarkerArray", markers=made)

    def _outlines(self, zone: Zone) -> list[FloatArray]:
        """Closed lines (n, 2), one a part, set units."""
        from demospec.planning.exports._moveit import grown_hulls

        if isinstance(zone.shape, Disc):
            angle = np.linspace(0.0, 2 * np.pi, 49)
            ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
            return [np.asarray(zone.shape.center) + (zone.shape.radius + zone.radius) * ring]
        hulls = grown_hulls(zone.shape, zone.radius)
        return [np.concatenate([hull, hull[:1]]) for hull in hulls]

    def _strip(self, number: int, name: str, rim: FloatArray) -> Any:
        red, green, blue = _COLOUR
        new = self._new
        return new(
            "visualization_msgs/msg/Marker",
            header=self._header(),
            ns=name,
            id=number,
            type=4,  # LINE_STRIP
            action=0,  # ADD
            pose=self._pose(0.0, 0.0),
            scale=new("geometry_msgs/msg/Vector3", x=0.004, y=0.0, z=0.0),
            color=new("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=1.0),
            lifetime=new("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
            frame_locked=False,
            points=[self._point(x, y) for x, y in rim],
            colors=[],
            texture_resource="",
            texture=new(
                "sensor_msgs/msg/CompressedImage",
                header=self._header(),
                format="",
                data=np.empty(0, dtype=np.uint8),
            ),
            uv_coordinates=[],
            text=name,
            mesh_resource="",
            mesh_file=new(
                "visualization_msgs/msg/MeshFile", filename="", data=np.empty(0, dtype=np.uint8)
            ),
            mesh_use_embedded_materials=False,
        )

    def image(self) -> Any:
        """`sensor_msgs/Image`: the scene's picture, rgb8."""
        pixels = self.request.scene.pixels()
        height, width, _ = pixels.shape
        return self._new(
            "sensor_msgs/msg/Image",
            header=self._header(),
            height=height,
            width=width,
            encoding="rgb8",
            is_bigendian=0,
            step=3 * width,
            data=np.ascontiguousarray(pixels).ravel(),
        )
