"""Exports against the definitions of those who read them: MoveIt's messages, nav2's filters,
VDA 5050's schema, every release's rosbag2 reader; and the README beside each."""

from __future__ import annotations

import dataclasses
import json
import re
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from demospec.planning import ExportRequest, export_request, export_to
from demospec.planning.exports import FOLDERS
from demospec.rules import ClearanceRule, RuleSet, TypeRules
from demospec.scene import Capsule, Disc, Picture, Polygon, Scene, SceneObject

M = 0.004

MOVEIT = {
    "object_recognition_msgs/msg/ObjectType": "string key\nstring db",
    "octomap_msgs/msg/Octomap": "std_msgs/Header header\nbool binary\nstring id\n"
    "float64 resolution\nint8[] data",
    "octomap_msgs/msg/OctomapWithPose": "std_msgs/Header header\ngeometry_msgs/Pose origin\n"
    "octomap_msgs/Octomap octomap",
    "moveit_msgs/msg/CollisionObject": "std_msgs/Header header\ngeometry_msgs/Pose pose\n"
    "string id\nobject_recognition_msgs/ObjectType type\n"
    "shape_msgs/SolidPrimitive[] primitives\ngeometry_msgs/Pose[] primitive_poses\n"
    "shape_msgs/Mesh[] meshes\ngeometry_msgs/Pose[] mesh_poses\n"
    "shape_msgs/Plane[] planes\ngeometry_msgs/Pose[] plane_poses\n"
    "string[] subframe_names\ngeometry_msgs/Pose[] subframe_poses\n"
    "byte ADD=0\nbyte REMOVE=1\nbyte APPEND=2\nbyte MOVE=3\nbyte operation",
    "moveit_msgs/msg/AttachedCollisionObject": "string link_name\n"
    "moveit_msgs/CollisionObject object\nstring[] touch_links\n"
    "trajectory_msgs/JointTrajectory detach_posture\nfloat64 weight",
    "moveit_msgs/msg/RobotState": "sensor_msgs/JointState joint_state\n"
    "sensor_msgs/MultiDOFJointState multi_dof_joint_state\n"
    "moveit_msgs/AttachedCollisionObject[] attached_collision_objects\nbool is_diff",
    "moveit_msgs/msg/AllowedCollisionEntry": "bool[] enabled",
    "moveit_msgs/msg/AllowedCollisionMatrix": "string[] entry_names\n"
    "moveit_msgs/AllowedCollisionEntry[] entry_values\nstring[] default_entry_names\n"
    "bool[] default_entry_values",
    "moveit_msgs/msg/LinkPadding": "string link_name\nfloat64 padding",
    "moveit_msgs/msg/LinkScale": "string link_name\nfloat64 scale",
    "moveit_msgs/msg/ObjectColor": "string id\nstd_msgs/ColorRGBA color",
    "moveit_msgs/msg/PlanningSceneWorld": "moveit_msgs/CollisionObject[] collision_objects\n"
    "octomap_msgs/OctomapWithPose octomap",
    "moveit_msgs/msg/PlanningScene": "string name\nmoveit_msgs/RobotState robot_state\n"
    "string robot_model_name\ngeometry_msgs/TransformStamped[] fixed_frame_transforms\n"
    "moveit_msgs/AllowedCollisionMatrix allowed_collision_matrix\n"
    "moveit_msgs/LinkPadding[] link_padding\nmoveit_msgs/LinkScale[] link_scale\n"
    "moveit_msgs/ObjectColor[] object_colors\nmoveit_msgs/PlanningSceneWorld world\n"
    "bool is_diff",
}
"""The message definitions of MoveIt 2 that a planning scene is made of."""


@pytest.fixture(scope="module")
def request_() -> ExportRequest:
    rules = RuleSet(
        {"careful": TypeRules(ClearanceRule({"glass": 5.0, "bowl": 3.0, "utensil": 2.0}))},
        metres_per_unit=M,
    )
    objects = (
        SceneObject("glass-0", "glass", (45.0, 42.0), None, Disc((45.0, 42.0), 6.0)),
        SceneObject(
            "bowl-0", "bowl", (70.0, 60.0), None,
            Polygon([[62, 55], [78, 54], [80, 66], [70, 60], [63, 67]]),
        ),
        SceneObject("fork.1", "utensil", (20.0, 20.0), None, Capsule((14, 16), (28, 25), 1.5)),
    )  # fmt: skip
    picture = Picture(array=np.zeros((80, 100, 3), dtype=np.uint8))
    scene = Scene("0007", (10.0, 70.0), (90.0, 10.0), objects, picture)
    return export_request(rules, scene, "careful")


def filled(store: Any, name: str, given: Any) -> Any:
    """The message of a document, as the ROS 2 command line's setter makes it: fields that are not
    named keep their default; a field that the definition lacks, or of another type, fails."""
    from rosbags.interfaces import Nodetype

    _, fields = store.fielddefs[name]
    unknown = set(given) - {field for field, _ in fields}
    assert not unknown, f"{name} has no {unknown}"

    def value(kind: Any, item: Any, where: str) -> Any:
        node, what = kind
        if node == Nodetype.NAME:
            return filled(store, what, {} if item is None else item)
        if node == Nodetype.BASE:
            base = what[0]
            if item is None:
                return {"string": "", "bool": False}.get(base, 0.0 if "float" in base else 0)
            expected = {"string": str, "bool": bool}.get(base, (float if "float" in base else int))
            assert type(item) is expected, f"{where}: {item!r} is no {base}"
            return item
        inner, size = what
        items = [] if item is None else item
        assert isinstance(items, list), where
        assert node != Nodetype.ARRAY or item is None or len(items) == size, where
        if item is None and node == Nodetype.ARRAY:
            items = [None] * size
        made = [value(inner, i, where) for i in items]
        if inner[0] == Nodetype.BASE and inner[1][0] != "string":
            base = {"byte": "uint8", "octet": "uint8"}.get(inner[1][0], inner[1][0])
            return np.array(made, dtype=base)
        return made

    return store.types[name](
        **{field: value(kind, given.get(field), f"{name}.{field}") for field, kind in fields}
    )


def test_moveit_scene_is_a_planning_scene_message(request_: ExportRequest, tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]' brings rosbags")
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    types: dict[str, Any] = {}
    for name, text in MOVEIT.items():
        types.update(get_types_from_msg(text, name))
    store.register(types)
    export_to(request_, "moveit", tmp_path / "m")
    document = yaml.safe_load((tmp_path / "m" / "planning_scene.yaml").read_text())
    message = filled(store, "moveit_msgs/msg/PlanningScene", document)
    data = store.serialize_cdr(message, "moveit_msgs/msg/PlanningScene")
    back = store.deserialize_cdr(data, "moveit_msgs/msg/PlanningScene")
    objects = {o.id: o for o in back.world.collision_objects}
    assert set(objects) == {"glass-0", "bowl-0", "fork.1"}
    assert back.is_diff
    assert back.robot_state.is_diff
    for written in document["world"]["collision_objects"]:
        read = objects[written["id"]]
        assert read.operation == 0  # ADD
        assert (read.type.key, read.header.frame_id) == (
            written["type"]["key"],
            written["header"]["frame_id"],
        )
        assert len(read.primitives) == len(read.primitive_poses)
        assert len(read.meshes) == len(read.mesh_poses)
        for mesh, given in zip(read.meshes, written.get("meshes", []), strict=True):
            corners = [dataclasses.astuple(v)[:3] for v in mesh.vertices]
            assert corners == [(v["x"], v["y"], v["z"]) for v in given["vertices"]]
    # The setter of this test can fail: a field of another name, and a number that is a text.
    spoilt = {**document, "world": {"collision_object": []}}
    with pytest.raises(AssertionError, match="collision_object"):
        filled(store, "moveit_msgs/msg/PlanningScene", spoilt)
    with pytest.raises(AssertionError, match=r"PlanningScene\.is_diff"):
        filled(store, "moveit_msgs/msg/PlanningScene", {**document, "is_diff": "yes"})


ZONE_SET = {
    "type": "object",
    "required": [
        "headerId", "timestamp", "version", "manufacturer", "serialNumber", "zoneSet",
    ],
    "properties": {
        "headerId": {"type": "integer"},
        "timestamp": {"type": "string", "pattern": r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d+Z$"},
        "version": {"type": "string", "pattern": r"^3\.\d+\.\d+$"},
        "manufacturer": {"type": "string"},
        "serialNumber": {"type": "string"},
        "zoneSet": {
            "type": "object",
            "required": ["mapId", "zoneSetId", "zones"],
            "properties": {
                "mapId": {"type": "string"},
                "zoneSetId": {"type": "string"},
                "zones": {"type": "array", "items": {"$ref": "#/$defs/zone"}},
            },
        },
    },
    "$defs": {
        "zone": {
            "type": "object",
            "required": ["zoneId", "zoneType", "vertices"],
            "properties": {
                "zoneId": {"type": "string"},
                "zoneType": {"enum": ["BLOCKED", "SPEED_LIMIT", "PENALTY", "RELEASE"]},
                "vertices": {
                    "type": "array",
                    "minItems": 3,
                    "items": {
                        "type": "object",
                        "required": ["x", "y"],
                        "properties": {"x": {"type": "number"}, "y": {"type": "number"}},
                        "additionalProperties": False,
                    },
                },
            },
            "if": {"properties": {"zoneType": {"const": "SPEED_LIMIT"}}},
            "then": {
                "required": ["maximumSpeed"],
                "properties": {"maximumSpeed": {"type": "number", "exclusiveMinimum": 0}},
            },
        }
    },
}  # fmt: skip
"""The required fields and types of VDA 5050 3.0's zone set, restated."""


def test_vda5050_zones_fit_the_schema_and_hold_the_clearances(
    request_: ExportRequest, tmp_path: Path
) -> None:
    import jsonschema
    from scipy.spatial import Delaunay

    export_to(request_, "vda5050", tmp_path / "v")
    document = json.loads((tmp_path / "v" / "zone_set.json").read_text())
    jsonschema.Draft202012Validator(ZONE_SET).validate(document)
    zones = document["zoneSet"]["zones"]
    assert len({z["zoneId"] for z in zones}) == len(zones)
    p = np.random.default_rng(3).uniform([0, 0], [100, 80], (3000, 2))
    metres = np.column_stack([p[:, 0], 80 - p[:, 1]]) * M  # y from the picture's lower edge
    for zone in request_.cost_map.zones:
        gap = zone.shape.signed_distance(p) - zone.radius
        for kind, reach in (("BLOCKED", 0.0), ("SPEED_LIMIT", zone.radius)):
            (found,) = [z for z in zones if z["zoneId"] == f"{zone.object_id}/{kind}"]
            corners = np.array([[v["x"], v["y"]] for v in found["vertices"]])
            within = Delaunay(corners).find_simplex(metres) >= 0
            assert within[gap < reach].all()
            if not isinstance(zone.shape, Polygon):  # the bowl is not convex
                assert not within[gap > reach + 0.2 * (1 + zone.radius)].any()
    slow = {z["maximumSpeed"] for z in zones if z["zoneType"] == "SPEED_LIMIT"}
    assert list(slow) == pytest.approx([0.3 * request_.speed_m_s])


def test_another_clearance_is_another_zone_set(request_: ExportRequest, tmp_path: Path) -> None:
    wider = dataclasses.replace(
        request_.cost_map,
        zones=tuple(dataclasses.replace(z, radius=z.radius + 1) for z in request_.cost_map.zones),
    )
    ids = []
    for i, where in enumerate((request_.cost_map, request_.cost_map, wider)):
        out = tmp_path / str(i)
        export_to(dataclasses.replace(request_, cost_map=where), "vda5050", out)
        ids.append(json.loads((out / "zone_set.json").read_text())["zoneSet"]["zoneSetId"])
    assert ids[0] == ids[1] != ids[2]


def test_recordings_read_by_the_types_of_each_release(
    request_: ExportRequest, tmp_path: Path
) -> None:
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="pip install 'demospec[ros]'")
    from rosbags.typesys import Stores, get_typestore

    export_to(request_, "rosbag2", tmp_path / "b")
    with rosbag2.Reader(tmp_path / "b" / "bag") as reader:
        messages = [(c.msgtype, raw) for c, _, raw in reader.messages()]
    assert len(messages) == 4
    for release in ("HUMBLE", "IRON", "JAZZY", "KILTED"):
        store = get_typestore(getattr(Stores, f"ROS2_{release}"))
        for kind, raw in messages:
            message = store.deserialize_cdr(raw, kind)
            assert bytes(store.serialize_cdr(message, kind)) == bytes(raw), release


def test_metadata_of_the_recording_holds_what_each_release_asks_for(
    request_: ExportRequest, tmp_path: Path
) -> None:
    pytest.importorskip("rosbags", reason="pip install 'demospec[ros]' brings rosbags")
    export_to(request_, "rosbag2", tmp_path / "b")
    about = yaml.safe_load((tmp_path / "b" / "bag" / "metadata.yaml").read_text())
    information = about["rosbag2_bagfile_information"]
    # Fields by the version of the metadata that first asks for them: 4 Foxy, 5 Galactic and
    # Humble (files), 7 Iron (type hash), 8 Jazzy (QoS as text or list).
    asked = {
        4: {"version", "storage_identifier", "duration", "starting_time", "message_count",
            "topics_with_message_count", "compression_format", "compression_mode",
            "relative_file_paths"},
        5: {"files"},
        8: {"custom_data", "ros_distro"},
    }  # fmt: skip
    for version, fields in asked.items():
        if information["version"] >= version:
            assert fields <= set(information), version
    for file, name in zip(information["files"], information["relative_file_paths"], strict=True):
        assert file["path"] == name
        assert (tmp_path / "b" / "bag" / name).is_file()
    for topic in information["topics_with_message_count"]:
        assert {"name", "type", "serialization_format", "offered_qos_profiles"} <= set(
            topic["topic_metadata"]
        )
        assert topic["topic_metadata"]["type_description_hash"].startswith("RIHS01_")
        assert topic["topic_metadata"]["serialization_format"] == "cdr"


def test_nav2_readme_and_filters_name_the_same_topics(
    request_: ExportRequest, tmp_path: Path
) -> None:
    export_to(request_, "nav2", tmp_path / "n")
    text = (tmp_path / "n" / "README.txt").read_text()
    servers = yaml.safe_load((tmp_path / "n" / "filters.yaml").read_text())
    start, end = text.index("filters: ["), text.index("\n\nThe clearance")
    costmap = yaml.safe_load(text[start:end])
    for name, kind in (("keepout", 0), ("speed", 1)):
        server = servers[f"{name}_filter_info_server"]["ros__parameters"]
        assert server["type"] == kind
        assert costmap[f"{name}_filter"]["filter_info_topic"] == server["filter_info_topic"]
        assert f"{name}_filter" in costmap["filters"]
        assert server["mask_topic"] == f"{name}_mask"
        # nav2's speed filter: limit = base + multiplier · mask, percent of the full speed.
        assert (server["base"], server["multiplier"]) == (0.0, 1.0)
    assert "topic_name:=keepout_mask" in text
    assert "__node:=keepout_filter_info_server" in text


@pytest.mark.parametrize("form", sorted(FOLDERS))
def test_a_readme_is_beside_each_and_names_files_that_are_there(
    form: str, request_: ExportRequest, tmp_path: Path
) -> None:
    if form == "rosbag2":
        pytest.importorskip("rosbags", reason="pip install 'demospec[ros]' brings rosbags")
    out = tmp_path / "out"
    export_to(request_, form, out)
    text = (out / "README.txt").read_text()
    there = {f.name for f in out.rglob("*")} - {"README.txt"}
    assert any(name in text for name in there)
    words = set(re.findall(r"[\w.]+", text))
    endings = (".yaml", ".json", ".csv", ".py", ".npz")
    assert {w for w in words if w.endswith(endings)} <= there
    if form == "numpy":  # its lines run as they stand
        rule = runpy.run_path(str(out / "rule.py"))
        assert rule["margin"]([[40.0, 30.0]]).shape == (1,)
    if form == "stl":
        assert "variables" in json.loads((out / "rule.json").read_text())
