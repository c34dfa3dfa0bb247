"""From percepts to proposals: events, behaviors, mediator, mapping."""
