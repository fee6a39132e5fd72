"""One label in twenty is wrong: which ones would you look at again?

python examples/03_check_and_audit.py
"""

from __future__ import annotations

from demospec import simulate_set
from demospec.specification import audit_set

data, _ = simulate_set(demonstrations=6, label_noise=0.05, seed=3)
audit = audit_set(data)
doubtful = [entry for entry in audit.entries if entry.verdict == "review"]
for entry in doubtful:
    print(f"{entry.demo_id}: {entry.why}")
print(f"{len(doubtful)} of {len(audit.entries)} demonstrations to look at again")
