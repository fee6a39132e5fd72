"""Contacts that Tesseract finds between the tool and a table, for places on standard input.

    python tesseract_contacts.py FOLDER < places.json    # [[x, y, z], …] metres

Prints {"margins": {object: m}, "contacts": [[object, …], …], "distances": [{object: m}, …]}.
Runs in an environment of its own with the wheel `tesseract-robotics`.
"""

import glob
import json
import os
import shutil
import sys
import tempfile

folder = tempfile.mkdtemp()
shutil.copytree(sys.argv[1], folder, dirs_exist_ok=True)
os.environ["TESSERACT_RESOURCE_PATH"] = folder

from tesseract_robotics import tesseract_collision as collision  # noqa: E402
from tesseract_robotics import tesseract_common as common  # noqa: E402
from tesseract_robotics import tesseract_environment as environments  # noqa: E402

# The wheel carries the plugins under names of its own, beside itself.
beside = os.path.join(os.path.dirname(collision.__file__), "..", "..", "tesseract_robotics.libs")
beside = os.path.abspath(beside)
plugins = os.path.join(folder, "demospec_table", "contact_managers.yaml")
with open(plugins) as file:
    text = file.read()
for name in ("tesseract_collision_bullet_factories", "tesseract_collision_fcl_factories"):
    (own,) = glob.glob(os.path.join(beside, f"lib{name}-*.so"))
    text = text.replace(f"- {name}\n", f"- {os.path.basename(own)[3:-3]}\n")
with open(plugins, "w") as file:
    file.write(
        text.replace("  search_libraries", f"  search_paths: [{beside}]\n  search_libraries")
    )

base = os.path.join(folder, "demospec_table", "table")
environment = environments.Environment()
locator = common.GeneralResourceLocator()
ok = environment.init(
    common.FilesystemPath(base + ".urdf"), common.FilesystemPath(base + ".srdf"), locator
)
if not ok:
    sys.exit("Tesseract does not take the files")
fixed = {"world", "tool", "tool_x", "tool_y"}
things = [str(name) for name in environment.getLinkNames() if str(name) not in fixed]
known = environment.getCollisionMarginData()
margins = {name: known.getPairCollisionMargin("tool", name) for name in things}


def found(manager, place):
    environment.setState({f"tool_{k}_joint": at for k, at in zip("xyz", place, strict=True)})
    state = environment.getState()  # keeps the transforms alive
    manager.setCollisionObjectsTransform(state.link_transforms)
    result = collision.ContactResultMap()
    manager.contactTest(result, collision.ContactRequest(collision.ContactTestType_ALL))
    flat = collision.ContactResultVector()
    result.flattenMoveResults(flat)
    out = {}
    for k in range(flat.size()):
        hit = flat[k]
        one, other = hit.link_names[0], hit.link_names[1]
        name = other if one == "tool" else one
        out[name] = min(hit.distance, out.get(name, float("inf")))
    return out


def manager_of(margin=None):
    manager = environment.getDiscreteContactManager()
    manager.setActiveCollisionObjects(["tool"])
    if margin is not None:
        wide = common.CollisionMarginData(margin)
        for name in things:
            wide.setPairCollisionMargin("tool", name, margin)
        manager.setCollisionMarginData(wide)
    return manager


places = json.load(sys.stdin)
kept, wide = manager_of(), manager_of(10.0)
print(
    json.dumps(
        {
            "margins": margins,
            "contacts": [sorted(found(kept, p)) for p in places],
            "distances": [found(wide, p) for p in places],
        }
    )
)
