"""Which effects are missing: first looks, rounds of fits, judgement."""
