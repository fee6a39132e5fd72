"""Whose demonstrations are these? Types of demonstrators whose names nobody wrote down.

python examples/22_whose_demonstrations.py
"""

from __future__ import annotations

from demospec import learn_rules, simulate_set
from demospec.specification import identify

data, _ = simulate_set(demonstrations=8, seed=6)
rules = learn_rules(data)
for who in identify(rules, data.of_split("test")).demonstrators:
    print(f"{who.demonstrator}: {who.type} (p = {who.posterior[who.type]:.2f}, {who.n} paths)")
