"""What a rollout looked like: a video, and a strip of pictures with the time beneath each."""

from __future__ import annotations

import importlib
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from demospec.errors import DemospecError, InputError, MissingExtraError
from demospec.execution._results import Rollout
from demospec.execution._robots import ARMS
from demospec.files import writing_file
from demospec.frames import FloatArray
from demospec.planning import Plan
from demospec.scene import Image, Scene

if TYPE_CHECKING:
    import mujoco

FRAMES_PER_S = 12
_WIDTH, _HEIGHT = 576, 432  # whole macro blocks, for MP4
_PLAN_RGBA = (0.0, 0.447, 0.698, 1.0)  # Okabe–Ito blue


def save_video(rollout: Rollout, plan: Plan, scene: Scene, path: str | os.PathLike[str]) -> None:
    """Writes a GIF, or an MP4 where the name ends so (needs imageio-ffmpeg).

    Raises:
        InputError: Nothing moved, or another ending.
        DemospecError: No EGL on this machine.
    """
    ending = os.fspath(path).rsplit(".", 1)[-1].lower()
    if ending not in ("gif", "mp4"):
        raise InputError("a name that ends in .gif or .mp4", os.fspath(path), field="video")
    t = rollout.motion.t
    times = np.arange(0.0, float(t[-1]) + 1e-9, 1 / FRAMES_PER_S) if len(t) else np.empty(0)
    frames = render(rollout, plan, scene, times)
    with writing_file(path) as temporary:
        if ending == "mp4":
            _write_mp4(frames, os.fspath(temporary))
            return
        import PIL.Image

        pictures = [
            PIL.Image.fromarray(f).quantize(96, dither=PIL.Image.Dither.NONE) for f in frames
        ]
        pictures[0].save(
            temporary,
            format="GIF",
            save_all=True,
            append_images=pictures[1:],
            duration=round(1000 / FRAMES_PER_S),
            loop=0,
        )


def save_strip(
    rollout: Rollout, plan: Plan, scene: Scene, path: str | os.PathLike[str], n: int = 4
) -> None:
    """Writes a PNG with `n` moments side by side, from start to goal.

    Raises:
        InputError: Nothing moved.
        DemospecError: No EGL on this machine.
    """
    import PIL.Image
    import PIL.ImageDraw

    t = rollout.motion.t
    times = np.linspace(0.0, float(t[-1]), n) if len(t) else np.empty(0)
    frames = render(rollout, plan, scene, times)
    strip = PIL.Image.new("RGB", (n * _WIDTH, _HEIGHT + 44), "white")
    draw = PIL.ImageDraw.Draw(strip)
    for i, (at, frame) in enumerate(zip(times, frames, strict=True)):
        strip.paste(PIL.Image.fromarray(frame), (i * _WIDTH, 0))
        words = f"{rollout.robot}, t = {at:.1f} s"
        draw.text((i * _WIDTH + 8, _HEIGHT + 6), words, fill="black", font_size=28)
    with writing_file(path) as temporary:
        strip.save(temporary, format="PNG")


def render(rollout: Rollout, plan: Plan, scene: Scene, times: FloatArray) -> list[Image]:
    """One picture (432, 576, 3) per time, with the plan drawn as a blue line."""
    if rollout.status != "done":
        found = f"{rollout.status}: {rollout.reason}"
        raise InputError("a plan that was carried out", found, field="rollout")
    import mujoco

    from demospec.execution._execute import CARRIED, table_placement
    from demospec.execution._world import build_gantry_world, build_world

    arm = ARMS.get(rollout.robot)
    place = table_placement(plan, scene, arm)
    motion = rollout.motion
    if arm is None:
        first = motion.commanded_m[0]
        world = build_gantry_world(scene, place, first, *CARRIED[rollout.carried])
    else:
        world = build_world(arm, scene, place, *CARRIED[rollout.carried])
    model = world.model
    data = mujoco.MjData(model)
    way = place.to_world(plan.points, 0.003)
    middle = place.to_world(place.middle)[0]
    camera = mujoco.MjvCamera()
    camera.lookat[:] = middle + np.array([-0.12, 0.0, 0.08]) * (arm is not None)
    camera.distance, camera.azimuth, camera.elevation = 1.75 if arm else 1.35, 150.0, -38.0
    frames = []
    with _renderer(model) as renderer:
        for at in times:
            data.qpos[:] = motion.joints[int(np.abs(motion.t - at).argmin())]
            mujoco.mj_forward(model, data)
            renderer.update_scene(data, camera=camera, scene_option=_looks())
            for a, b in pairwise(way):
                _line(renderer.scene, a, b)
            frames.append(np.array(renderer.render()))
    return frames


def _looks() -> Any:
    """Show what can be seen, and collision shapes too where a robot has no other."""
    import mujoco

    option = mujoco.MjvOption()
    option.geomgroup[:] = 1
    return option


@contextmanager
def _renderer(model: mujoco.MjModel) -> Iterator[Any]:
    import mujoco

    # PyTorch's builds for GPUs bring Triton, and Mesa draws without a screen: both have an LLVM.
    # Loaded after Mesa's, Triton's ends the process (with PyTorch's first optimiser); before it,
    # both work.
    with suppress(ImportError):
        importlib.import_module("triton")
    try:
        renderer = mujoco.Renderer(model, height=_HEIGHT, width=_WIDTH)
    except Exception as error:  # OpenGL platforms raise whatever they like
        raise DemospecError(
            f"no picture can be drawn: EGL is missing (Debian: apt install libegl1): {error}"
        ) from error
    try:
        yield renderer
    finally:
        renderer.close()


def _line(scene: mujoco.MjvScene, a: FloatArray, b: FloatArray) -> None:
    import mujoco

    if scene.ngeom >= scene.maxgeom:
        return
    geom = scene.geoms[scene.ngeom]
    capsule = mujoco.mjtGeom.mjGEOM_CAPSULE
    rgba = np.array(_PLAN_RGBA, dtype=np.float32)
    mujoco.mjv_initGeom(geom, capsule, np.zeros(3), np.zeros(3), np.eye(3).ravel(), rgba)
    mujoco.mjv_connector(geom, capsule, 0.004, a, b)
    scene.ngeom += 1


def _write_mp4(frames: list[Image], path: str) -> None:
    try:
        import imageio.v3 as imageio

        importlib.import_module("imageio_ffmpeg")  # imageio asks for it later, less clearly
    except ImportError as error:
        raise MissingExtraError("imageio-ffmpeg", "robot", "an MP4 video") from error
    imageio.imwrite(path, np.stack(frames), fps=FRAMES_PER_S, codec="libx264")
