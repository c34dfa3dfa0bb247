"""Who drives: the mediator and its strategies."""
