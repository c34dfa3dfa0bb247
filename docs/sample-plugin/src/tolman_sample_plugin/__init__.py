"""A sample of a distribution with a behavior and a mediator for tolman."""
