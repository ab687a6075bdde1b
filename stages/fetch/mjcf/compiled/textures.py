"""Reads the textures that a compiled model's materials give to its meshes."""

from __future__ import annotations

from hashlib import sha256

import mujoco
import numpy as np

from linkwright.stages.formats import png

_COLOUR_ROLES = (mujoco.mjtTextureRole.mjTEXROLE_RGB, mujoco.mjtTextureRole.mjTEXROLE_RGBA)
"""The uses of a texture that are a colour."""


class Textures:
    """The requested textures of a model.

    `images`: digest → the PNG of a texture.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._digests: dict[int, str] = {}
        self._used: set[int] = set()
        self._lost: set[int] = set()
        self.images: dict[str, bytes] = {}

    @property
    def carried_numbers(self) -> set[int]:
        """The numbers of the textures that are carried over."""
        return set(self._digests)

    @property
    def materials(self) -> set[int]:
        """The numbers of the materials whose textures are carried over wherever they are visible."""
        return self._used - self._lost

    def of(self, geom: int) -> str:
        """Returns the digest of the image of a visible geom.

        Returns "" without an image, and for an image that is not carried over: a cube's, an image on a shape
        without texture coordinates, or an image of more than a colour.
        """
        model = self._model
        material = int(model.geom_matid[geom])
        if material < 0 or not (model.mat_texid[material] >= 0).any():
            return ""
        roles = model.mat_texid[material]
        texture = max(int(roles[role]) for role in _COLOUR_ROLES)
        carried_numbers = texture >= 0 and self._is_flat(texture) and self._has_coordinates(geom)
        is_only_role = (roles >= 0).sum() == 1
        (self._used if carried_numbers and is_only_role else self._lost).add(material)
        return self._image(texture) if carried_numbers else ""

    def _is_flat(self, texture: int) -> bool:
        model = self._model
        pixels = int(model.tex_height[texture]) * int(model.tex_width[texture])
        has_usual_size = model.tex_nchannel[texture] in (1, 3, 4) and 0 < pixels <= png.MAX_PIXELS
        return bool(has_usual_size and model.tex_type[texture] == mujoco.mjtTexture.mjTEXTURE_2D)

    def _has_coordinates(self, geom: int) -> bool:
        model = self._model
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
            return False
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_texcoordadr[mesh]), int(model.mesh_texcoordnum[mesh])
        return first >= 0 and bool(np.isfinite(model.mesh_texcoord[first : first + count]).all())

    def _image(self, texture: int) -> str:
        """Returns the digest of a texture's PNG. MuJoCo's first row is the upper one, as in a PNG."""
        if texture not in self._digests:
            model = self._model
            height, width = int(model.tex_height[texture]), int(model.tex_width[texture])
            channels, first = int(model.tex_nchannel[texture]), int(model.tex_adr[texture])
            pixels = model.tex_data[first : first + height * width * channels]
            data = png.encode(pixels.reshape(height, width, channels))
            self._digests[texture] = sha256(data).hexdigest()
            self.images[self._digests[texture]] = data
        return self._digests[texture]
