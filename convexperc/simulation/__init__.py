"""A simulated park and lab in which robots look at an object, partly hidden by obstacles.

`Scene` describes a scene, `mjcf` writes it as MuJoCo's XML, `SceneRenderer` draws it, and `write_data_set`
makes folders of pictures with masks. Only the functions that draw import MuJoCo.
"""

from convexperc.faces import attach

__getattr__, __dir__, __all__ = attach(__name__)
