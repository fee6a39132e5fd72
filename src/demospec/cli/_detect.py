"""`demospec detect`: the objects in pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from demospec.cli._common import (
    Force,
    Json,
    print_json,
    print_table,
    save_json,
    say,
)
from demospec.cli._detectors import DetectorName, Symbols, other_detector, say_skipped

if TYPE_CHECKING:
    from demospec.perception import DetectedObject
    from demospec.scene import Picture, SceneObject


def detect(
    source: Annotated[
        Path, typer.Argument(metavar="IMAGE|SET", help="A picture, or a demonstration set.")
    ],
    named: Annotated[
        Path | None,
        typer.Option(
            "--set", metavar="SET", help="Learn the symbols from the object lists of this set."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="JSON file, or folder of a new set, to write.")
    ] = None,
    overlay: Annotated[
        Path | None, typer.Option("--overlay", help="Draw the detected objects (PNG).")
    ] = None,
    scene_id: Annotated[
        str | None, typer.Option("--scene", help="The scene of a set to draw (default: first).")
    ] = None,
    least: Annotated[
        float, typer.Option("--least", min=0, max=1, help="Least confidence of an object.")
    ] = 0.5,
    detector: DetectorName = None,
    symbols: Symbols = None,
    body: Annotated[
        Path | None,
        typer.Option("--body", help="Weights of the distance network (from `demospec pretrain`)."),
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Detect the objects in a picture, or in every picture of a set.

    A picture gives JSON {"objects": [...]} in the set format. A set gives a new set (--out a
    folder) whose scenes list the detected objects in place of the listed ones; or JSON (--out
    a .json). Without --set the symbols are generic words: flat, hollow, clear, long, tool, block,
    round. A set that lists objects in training scenes names its own test scenes. Another
    detector gives the lists with --detector (json:RESULTS, onnx:MODEL.onnx,
    torchvision:NAME:WEIGHTS.pth, or one that a package brings).
    """
    from demospec.demonstrations import read_set
    from demospec.errors import InputError
    from demospec.perception import fit_symbol_head, load_network

    if not source.exists():
        raise InputError("a picture or a demonstration set", "nothing there", file=source)
    if detector is not None:
        _refuse({"--set": named, "--body": body}, "--detector")
        how = other_detector(detector, symbols)
        if source.is_dir():
            _detect_set(source, how, least, out, overlay, scene_id, force, json)
        else:
            _foreign_picture(source, how, least, out, overlay, scene_id, json)
        return
    _refuse({"--symbols": symbols}, "no --detector")
    network = load_network(body)
    head = None
    if named is not None:
        from demospec.cli._common import progress_bar

        teacher = read_set(named)
        with progress_bar() as progress:
            head = fit_symbol_head(
                [s for s in teacher.scenes if s.split != "test"], network=network, progress=progress
            )
        if head is None:
            raise InputError(
                "training scenes with pictures and lists of objects", "none", file=named
            )
    if source.is_dir():
        how = {"network": network, "head": head}
        _detect_set(source, how, least, out, overlay, scene_id, force, json)
        return
    from demospec.perception import detect_objects, observe
    from demospec.scene import Picture

    if scene_id is not None:
        raise InputError("no scene for a single picture", scene_id, field="--scene")
    picture = Picture(file=source)
    observation = observe(picture.pixels, network=network)
    found = detect_objects(observation, head=head, least=least)
    known = {} if observation.familiarity is None else observation.familiarity.to_json()
    _tell(source, picture, found, out, overlay, json, named=head is not None, known=known)


def _refuse(given: dict[str, object], beside: str) -> None:
    from demospec.errors import InputError

    for option, value in given.items():
        if value is not None:
            raise InputError(f"{option} left out (there is {beside})", value, field=option)


def _foreign_picture(
    source: Path,
    how: dict[str, Any],
    least: float,
    out: Path | None,
    overlay: Path | None,
    scene_id: str | None,
    json: bool,
) -> None:
    from demospec.errors import InputError
    from demospec.perception import detect_with
    from demospec.scene import Picture, Scene

    if scene_id is not None:
        raise InputError("no scene for a single picture", scene_id, field="--scene")
    picture = Picture(file=source)
    scene = Scene(source.stem, (0.0, 0.0), (0.0, 0.0), picture=picture)
    found = detect_with(how["detector"], scene, symbols=how["symbols"], least=least)
    if found is None:
        raise InputError(f"detections for {source.name}", "none", field=how["detector"].name)
    _tell(source, picture, found, out, overlay, json, named=True)


def _tell(
    source: Path,
    picture: Picture,
    found: Sequence[DetectedObject],
    out: Path | None,
    overlay: Path | None,
    json: bool,
    *,
    named: bool,
    known: dict[str, Any] | None = None,
) -> None:
    from demospec.perception import overlay_picture

    known = known or {}
    things = [thing.to_json() for thing in found]
    document = {"size_px": list(picture.size_px), **known, "objects": things}
    save_json(document, out)
    say_unfamiliar({source.name: known.get("reason")})
    if overlay is not None:
        overlay_picture(picture.pixels, found, overlay)
        say(f"wrote {overlay}")
    if json:
        print_json(document)
    else:
        _print(source.name, [(None, found)], named)


def _detect_set(
    source: Path,
    how: dict[str, Any],
    least: float,
    out: Path | None,
    overlay: Path | None,
    scene_id: str | None,
    force: bool,
    json: bool,
) -> None:
    from demospec.cli._common import progress_bar
    from demospec.demonstrations import read_set, write_set
    from demospec.errors import InputError
    from demospec.files import check_free_folder
    from demospec.perception import detect_in_set, overlay_picture

    data = read_set(source)
    folder = out if out is not None and out.suffix != ".json" else None
    if folder is not None:
        check_free_folder(folder, replace=force)
    if scene_id is not None:
        data.scene(scene_id)
    with progress_bar() as progress:
        seen, skipped = detect_in_set(data, least=least, progress=progress, **how)
    say_skipped(data, skipped)
    if folder is not None:
        write_set(seen, folder, replace_existing=force)
        say(f"wrote {folder}")
    document: dict[str, Any] = {"scenes": []}
    for s in seen.scenes:
        if s.scene_id not in skipped:
            own = dict(s.extra)["detector"]
            known = {k: own[k] for k in ("familiar", "reason") if k in own}
            things = [thing.to_json() for thing in s.objects or ()]
            document["scenes"].append({"scene_id": s.scene_id, **known, "objects": things})
    say_unfamiliar({s["scene_id"]: s.get("reason") for s in document["scenes"]})
    if folder is None:
        save_json(document, out)
    if overlay is not None:
        shown = [s for s in seen.scenes if s.scene_id not in skipped]
        if scene_id is not None:
            shown = [s for s in shown if s.scene_id == scene_id]
        if not shown:
            raise InputError("a scene with a picture", scene_id, field="--scene")
        overlay_picture(shown[0].pixels(), shown[0].objects or (), overlay)
        say(f"wrote {overlay}")
    if json:
        print_json(document)
    else:
        rows = [(s.scene_id, s.objects or ()) for s in seen.scenes if s.scene_id not in skipped]
        _print(seen.name, rows, how.get("head") is not None or "detector" in how)


def say_unfamiliar(reasons: Mapping[str, str | None]) -> None:
    """Says which pictures the network does not know, and what to do; nothing for familiar ones."""
    strange = {name: reason for name, reason in reasons.items() if reason}
    if not strange:
        return
    some = ", ".join(list(strange)[:5]) + (", …" if len(strange) > 5 else "")
    why = ", ".join(dict.fromkeys(strange.values()))
    say(
        f"unlike the pictures that the detector was trained on: {some} ({why}). Look at what was "
        "found; list the objects, or bring a detector (--detector)"
    )


def _print(
    title: str, scenes: Sequence[tuple[str | None, Sequence[SceneObject]]], named: bool
) -> None:
    rows: list[list[Any]] = []
    for name, found in scenes:
        for thing in found:
            x, y, right, low = thing.outline.bounds
            width, height = right - x, low - y
            sure = getattr(thing, "confidence", 1.0)
            row: list[Any] = [
                thing.id,
                thing.symbol,
                *(round(v, 1) for v in (*thing.center, width, height)),
            ]
            rows.append([*([] if name is None else [name]), *row, round(sure, 2)])
    header = ["object", "symbol", "x px", "y px", "width px", "height px", "confidence"]
    if scenes and scenes[0][0] is not None:
        header = ["scene", *header]
    note = "" if named else "Symbols are generic words; --set SET uses the symbols of a set."
    print_table(f"{title}: {len(rows)} objects detected", header, rows, note=note)
