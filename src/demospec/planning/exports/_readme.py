"""``README.txt`` beside an export: the few lines that make a robot use it."""

from __future__ import annotations

from pathlib import Path

NAME = "README.txt"


def write_readme(form: str, folder: Path) -> None:
    """Writes ``README.txt``; nothing for a form that has none."""
    if form in READMES:
        (folder / NAME).write_text(READMES[form], encoding="utf-8")


READMES = {
    "nav2": """\
Keep-out and speed masks for nav2, and a graded map. Serve the masks, from this folder:

ros2 run nav2_map_server map_server --ros-args -r __node:=keepout_mask_server \\
  -p yaml_filename:=keepout.yaml -p topic_name:=keepout_mask
ros2 run nav2_map_server costmap_filter_info_server --ros-args \\
  -r __node:=keepout_filter_info_server --params-file filters.yaml
ros2 run nav2_util lifecycle_bringup keepout_mask_server keepout_filter_info_server

(the same with "speed" in the place of "keepout"). In the parameters of the costmaps:

filters: ["keepout_filter", "speed_filter"]
keepout_filter: {plugin: "nav2_costmap_2d::KeepoutFilter", enabled: true,
  filter_info_topic: "keepout_filter_info"}
speed_filter: {plugin: "nav2_costmap_2d::SpeedFilter", enabled: true,
  filter_info_topic: "speed_filter_info", speed_limit_topic: "speed_limit"}

The clearance is that of a point: the costmap's own inflation layer adds the robot's size.
""",
    "moveit": """\
A planning scene for MoveIt 2: each object grown by its own clearance. With move_group running:

ros2 topic pub --once /planning_scene moveit_msgs/msg/PlanningScene "$(cat planning_scene.yaml)"

padding.json says what was added to which object. The frame of the objects (header.frame_id) must
be known to tf: another name is written by  demospec export ... --frame-id NAME.
""",
    "ompl": """\
A validity checker and an objective for OMPL's Python bindings. rule.py needs numpy and ompl only:

import rule
information = rule.space_information()
objective = rule.objective(information)

Coordinates are those of the set; rule.START and rule.GOAL are the scene's.
""",
    "numpy": """\
The rule as plain functions of points (n, 2), in the set's units. rule.py needs numpy only:

import rule
rule.margin([[40.0, 30.0]])    # >= 0 where the rule is kept
rule.cost([[40.0, 30.0]])      # cost_map.npz holds the same on a grid
""",
    "rosbag2": """\
The plan, the map and the objects as a ROS 2 recording. To look at it:

ros2 bag info bag
ros2 bag play bag --loop
rviz2    # fixed frame: that of the messages; add by topic /plan, /cost_map, /objects, /scene
""",
    "stl": """\
The rule in signal temporal logic, and the plan's signals. With rtamt:

specification = rtamt.StlDiscreteTimeSpecification(); rule = json.load(open("rule.json"))
for name in rule["variables"]: specification.declare_var(name, "float")
specification.spec = rule["formula"]; specification.parse()

specification.evaluate(signals) of signals.csv gives the margin in the set's units; >= 0 keeps it.
""",
    "tesseract": """\
The table as URDF, and a margin for each pair of links as SRDF. With tesseract_robotics, and the
environment variable TESSERACT_RESOURCE_PATH naming this folder:

locator = tesseract_common.GeneralResourceLocator()
environment = tesseract_environment.Environment()
environment.init(FilesystemPath(".../demospec_table/table.urdf"),
                 FilesystemPath(".../demospec_table/table.srdf"), locator)

"tool" is a small ball at the point that the rule speaks of (its radius is taken off the margins).
For your own robot take the lines <pair_margin> into its SRDF with the name of your link in the
place of "tool"; margins.yaml lists the same.
""",
    "vda5050": """\
Zones of VDA 5050, version 3.0. Fill in the header, then publish to the robot:

set headerId, timestamp, manufacturer, serialNumber and your mapId in zone_set.json
mosquitto_pub -h BROKER -t uagv/v3/MANUFACTURER/SERIAL/zoneSet -f zone_set.json
enable it by the instant action enableZoneSet with its zoneSetId

Robots refuse a zoneSetId that they know, so it changes with the zones. Vertices are metres.
Blocked zones hold the clearance of a point: the robot's own size is the robot's to add.
""",
}
"""Form → text."""
