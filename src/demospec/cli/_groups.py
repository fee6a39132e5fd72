"""The commands in groups, and the examples that end each command's help."""

from __future__ import annotations

GROUPS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("Start here", ("demo", "studio", "doctor")),
    ("Your data", ("check", "audit", "convert", "edit", "simulate", "detect")),
    ("Learn", ("rules", "query", "fit")),
    ("Explain", ("predict", "evaluate", "identify", "causes", "scenes")),
    ("Use", ("plan", "repair", "sample", "export", "execute", "monitor", "check-run")),
    ("Study", ("report", "reproduce", "pretrain")),
)
"""Title and commands of each group, in the order of `demospec --help`."""

COMMANDS: tuple[str, ...] = tuple(name for _, names in GROUPS for name in names)
"""Every command; `demospec.cli._NAME` holds the function `NAME` (a hyphen becomes `_`)."""

EXAMPLES: dict[str, tuple[str, ...]] = {
    "demo": (
        "demospec demo --out runs/demo",
        "demospec demo --out runs/other --seed 1",
        "demospec demo --out runs/demo --json | jq -r .report",
    ),
    "studio": (
        "demospec studio",
        "demospec studio my-set --out my-set-taught",
        "demospec studio my-set --run runs/demo --model rules.json",
    ),
    "doctor": (
        "demospec doctor",
        "demospec doctor --json | jq .extras.robot",
        "demospec doctor --out environment.json",
    ),
    "check": (
        "demospec check my-set",
        "demospec check my-set --json --out faults.json",
        "demospec check my-set --json | jq .warnings",
    ),
    "audit": (
        "demospec audit my-set",
        "demospec audit my-set --picture suspicious.png --out audit.json",
        "demospec audit my-set --model field --folds 10",
    ),
    "convert": (
        "demospec convert recordings --dry-run",
        "demospec convert recordings my-set --units m --column x=tool_x",
        "demospec convert run.mcap my-set --path /tool_pose --map mapping.json",
    ),
    "edit": (
        "demospec edit relabel my-set --audit audit.json --out corrected",
        "demospec edit merge monday tuesday --out both",
        "demospec edit split my-set --test-share 0.25 --out parts",
    ),
    "simulate": (
        "demospec simulate --out my-set",
        "demospec simulate --out my-set --task workbench --train-scenes 5",
        "demospec simulate --out my-set --label-noise 0.05 --seed 7",
    ),
    "detect": (
        "demospec detect table.png --overlay seen.png",
        "demospec detect table.png --set my-set --json",
        "demospec detect my-set --set my-set --out my-set-seen",
    ),
    "rules": (
        "demospec rules my-set",
        "demospec rules my-set --out rules.json --picture envelopes.png",
        "demospec rules problem.json --engine exact --json",
    ),
    "query": (
        "demospec query my-set",
        "demospec query my-set --type careful --out question.json",
        "demospec query problem.json --error-rate 0.05",
    ),
    "fit": (
        "demospec fit my-set --out model",
        "demospec fit my-set --model paper --set steps=500 --out paper-model",
        "demospec fit my-set --members 5 --out ensemble",
    ),
    "predict": (
        "demospec predict rules.json my-set",
        "demospec predict model my-set --json --out predictions.json",
        "demospec predict model new-set --conformal 0.1 --calibrate held-out",
    ),
    "evaluate": (
        "demospec evaluate rules.json my-set",
        "demospec evaluate model my-set --split test",
        "demospec evaluate model my-set --truth my-set/truth.json --json",
    ),
    "identify": (
        "demospec identify rules.json my-set",
        "demospec identify model my-set --out people.json",
        "demospec identify model my-set --json | jq .demonstrators",
    ),
    "causes": (
        "demospec causes rules.json my-set --picture causes.png",
        "demospec causes model my-set --symbols glass,plate --split test",
        "demospec causes model my-set --interventions add,remove --out causes.json",
    ),
    "scenes": (
        "demospec scenes model my-set --out seen",
        "demospec scenes model my-set --scene 0003 --out seen",
        "demospec scenes model my-set --sample 20 --out new-set",
    ),
    "plan": (
        "demospec plan rules.json my-set --scene 0003 --type careful",
        "demospec plan rules.json my-set --scene 0003 --picture plan.png",
        "demospec plan rules.json my-set --scene 0003 --envelope value --json",
    ),
    "repair": (
        "demospec repair rules.json my-set --type careful",
        "demospec repair model my-set --type careful --rules my-set/truth.json",
        "demospec repair model my-set --type careful --particles 1 --out fixed.json",
    ),
    "sample": (
        "demospec sample rules.json my-set --scene 0003 --type careful",
        "demospec sample model my-set --scene 0003 --type careful --n 50 --json",
        "demospec sample model my-set --scene 0003 --type normal --method langevin",
    ),
    "export": (
        "demospec export rules.json my-set --scene 0003 --to nav2 --out nav2",
        "demospec export rules.json my-set --scene 0003 --to moveit --out moveit",
        "demospec export rules.json my-set --scene 0003 --to csv --out path.csv",
    ),
    "execute": (
        "demospec execute rules.json my-set --scene 0003 --type careful",
        "demospec execute rules.json my-set --scene 0003 --robot panda --out run",
        "demospec execute rules.json my-set --scene 0003 --truth my-set/truth.json",
    ),
    "monitor": (
        "demospec monitor rules.json my-set --scene 0003 --replay run.mcap",
        "robot | demospec monitor rules.json my-set --scene 0003 --stdin --metres",
        "demospec monitor rules.json my-set --scene 0003 --ros2 /tool_pose",
    ),
    "check-run": (
        "demospec check-run rules.json my-set --scene 0003 --run run.mcap",
        "demospec check-run rules.json my-set --scene 0003 --run bag --plan plan.json",
        "demospec check-run rules.json my-set --scene 0003 --run bag --picture run.png",
    ),
    "report": (
        "demospec report runs/demo",
        "demospec report my-run --out page.html",
        "demospec report my-run --markdown --out page",
    ),
    "reproduce": (
        "demospec reproduce --quick --out runs/quick",
        "demospec reproduce --out runs/paper --workers 8",
        "demospec reproduce --out runs/paper --device cuda",
    ),
    "pretrain": (
        "demospec pretrain --out network.safetensors",
        "demospec pretrain --init network.safetensors --steps 500 --out more.safetensors",
        "demospec pretrain --workers 4 --bfloat16 --out network.safetensors",
    ),
}
"""Three command lines of each command, which work as they stand where the files are there."""


def epilog(name: str) -> str | None:
    """The examples of a command as the last lines of its help; None where it has none."""
    lines = EXAMPLES.get(name)
    return None if lines is None else "\n".join(["\b", "Examples:", *(f"  {e}" for e in lines)])
