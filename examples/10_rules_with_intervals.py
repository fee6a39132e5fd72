"""Which objects matter to whom, how far, and how sure that is; a rule file for other programs.

python examples/10_rules_with_intervals.py [OUT]
"""

from __future__ import annotations

import sys
from pathlib import Path

from demospec import learn_rules, read_rules, simulate_set
from demospec.files import write_json
from demospec.rules import rules_document
from demospec.specification import evaluate

out = Path(sys.argv[1] if len(sys.argv) > 1 else "runs/10_rules_with_intervals")
data, _ = simulate_set(demonstrations=5, seed=2)
rules = learn_rules(data)
for user_type, rule in rules.rules.items():
    for symbol in rule.clearance.relevant if rule.clearance else ():
        low, high = rule.clearance.interval[symbol]
        value = rule.clearance.value[symbol]
        print(f"{user_type}: {symbol} {value:.2f} px, between {low:.2f} and {high:.2f} px")

write_json(out / "rules.json", rules_document(rules))
score = evaluate(read_rules(out / "rules.json"), data.of_split("test"))  # scenes never shown
print({t: s.balanced_accuracy for t, s in score.types.items()})
