"""How good a map or a trip was, by truth: floor and walls covered, places doubled, detours driven."""
