"""Recording a run, replaying it, and explaining it."""
