"""From percepts to proposals: events, the behavior contract, the mediator, path integration, mapping.

The agent knows its robot only through `tolman.world.robot`; it never sees where the robot truly is.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
