"""The robot and its surroundings: worlds as data, simulated with DART or kinematically."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
