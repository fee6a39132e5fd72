"""3-D paths onto a plane, and planes onto the picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from demospec.demonstrations.readers._mapping import PlaneMapping, ProjectionMapping
from demospec.errors import InputError
from demospec.frames import FloatArray

_AXES = {"xy": (0, 1, 2), "xz": (0, 2, 1), "yz": (1, 2, 0), "zx": (2, 0, 1)}


@dataclass(frozen=True)
class Projection:
    """Source coordinates → plane coordinates → pixels.

    Args:
        basis: (3, 3) rows: the plane's x axis, y axis and normal, orthonormal.
        origin: (3,), source units.
        homography: (3, 3) plane → pixels, or None: points stay in the plane's coordinates.
        residual_px: Root mean square of a fitted homography's residuals, or None.
    """

    basis: FloatArray
    origin: FloatArray
    homography: FloatArray | None = None
    residual_px: float | None = None

    @property
    def to_pixels(self) -> bool:
        """Whether the results are pixels."""
        return self.homography is not None

    def on_plane(self, points: ArrayLike) -> FloatArray:
        """(n, 2) or (n, 3) source points → (n, 3): plane x, plane y, height; source units."""
        p = np.asarray(points, dtype=np.float64)
        if p.shape[1] == 2:
            p = np.concatenate([p, np.zeros((len(p), 1))], axis=1)
        return np.asarray((p - self.origin) @ self.basis.T)

    @property
    def mirrors(self) -> bool:
        """Whether the plane's x, y and normal are left-handed (``xz``): seen from the side that
        the normal points to, y then points down."""
        return bool(np.linalg.det(self.basis) < 0)

    def turned(self, quaternions: FloatArray) -> FloatArray:
        """(n, 4) orientations x, y, z, w in the source's axes → in the plane's.

        The third axis is the plane's normal, so that a tilt stays what it is; where the plane is
        left-handed its y axis is turned round.
        """
        from scipy.spatial.transform import Rotation

        basis = self.basis.copy()
        if self.mirrors:
            basis[1] *= -1
        turned = Rotation.from_matrix(basis) * Rotation.from_quat(quaternions)
        return np.asarray(turned.as_quat())

    def apply(self, points: ArrayLike) -> FloatArray:
        """(n, 2) or (n, 3) source points → (n, 3): pixels where there is a homography, height.

        Raises:
            InputError: A point on the horizon of the homography.
        """
        plane = self.on_plane(points)
        if self.homography is None:
            return plane
        return np.concatenate([transform(self.homography, plane[:, :2]), plane[:, 2:]], axis=1)

    def unit_length(self, pixels: ArrayLike) -> tuple[float, float]:
        """Plane units per pixel at `pixels` (n, 2): the median, and max / min (1 if the map is a
        similarity: no perspective, no shear)."""
        assert self.homography is not None
        inverse = np.asarray(np.linalg.inv(self.homography), dtype=np.float64)
        p = np.asarray(pixels, dtype=np.float64)
        step = 0.5
        x, y = np.array([step, 0.0]), np.array([0.0, step])
        right = transform(inverse, p + x) - transform(inverse, p - x)
        down = transform(inverse, p + y) - transform(inverse, p - y)
        lengths = np.concatenate([np.linalg.norm(right, axis=1), np.linalg.norm(down, axis=1)])
        return float(np.median(lengths)), float(lengths.max() / lengths.min())


def transform(homography: FloatArray, points: ArrayLike) -> FloatArray:
    """(n, 2) → (n, 2) through a 3×3 homography; InputError on its horizon."""
    p = np.asarray(points, dtype=np.float64)
    image = np.concatenate([p, np.ones((len(p), 1))], axis=1) @ homography.T
    scale = image[:, 2:]
    size = np.abs(image).max(axis=1, keepdims=True)
    if (np.abs(scale) <= 1e-12 * size).any():
        at = int(np.flatnonzero((np.abs(scale) <= 1e-12 * size)[:, 0])[0])
        raise InputError(
            "points on the near side of the homography's horizon",
            f"[{p[at, 0]:g}, {p[at, 1]:g}]",
            field="projection.homography",
        )
    return np.asarray(image[:, :2] / scale)


def fit_homography(source: ArrayLike, target: ArrayLike) -> tuple[FloatArray, float]:
    """The homography that maps `source` (n, 2) to `target` (n, 2), n ≥ 4, and its residual.

    Direct linear transform on coordinates moved to the centroid and scaled to mean distance √2
    (Hartley, "In defence of the eight-point algorithm", 1997); exact for four pairs.

    Returns:
        (3, 3), and the root mean square distance in target units.

    Raises:
        InputError: Fewer than four pairs, or points of which three of four lie on a line.
    """
    a, b = np.asarray(source, dtype=np.float64), np.asarray(target, dtype=np.float64)
    if len(a) < 4:
        raise InputError("at least four pairs", len(a), field="projection.pairs")
    ta, tb = _normalizer(a), _normalizer(b)
    p, q = transform(ta, a), transform(tb, b)
    ones, zeros = np.ones(len(p)), np.zeros((len(p), 3))
    h = np.column_stack([p, ones])
    rows_u = np.concatenate([h, zeros, -q[:, :1] * h], axis=1)
    rows_v = np.concatenate([zeros, h, -q[:, 1:] * h], axis=1)
    _, singular, vectors = np.linalg.svd(np.concatenate([rows_u, rows_v]))
    if singular[7] < 1e-9 * singular[0]:
        raise InputError(
            "four pairs of which no three lie on a line", "points on a line",
            field="projection.pairs",
        )  # fmt: skip
    fitted = np.linalg.inv(tb) @ vectors[-1].reshape(3, 3) @ ta
    fitted = fitted / np.linalg.norm(fitted)
    if abs(np.linalg.det(fitted)) < 1e-15:
        raise InputError(
            "four pairs of which no three lie on a line", "points on a line",
            field="projection.pairs",
        )  # fmt: skip
    gap = transform(fitted, a) - b
    return fitted, float(np.sqrt((gap**2).sum(axis=1).mean()))


def _normalizer(points: FloatArray) -> FloatArray:
    centre = points.mean(axis=0)
    spread = float(np.linalg.norm(points - centre, axis=1).mean())
    if spread == 0:
        raise InputError("points at different places", "one place", field="projection.pairs")
    s = np.sqrt(2.0) / spread
    return np.array([[s, 0, -s * centre[0]], [0, s, -s * centre[1]], [0, 0, 1.0]])


def projection_of(mapping: ProjectionMapping | None) -> Projection | None:
    """The projection a mapping describes; None where it describes none."""
    if mapping is None:
        return None
    basis, origin = _plane(mapping.plane)
    flat = Projection(basis, origin)
    if mapping.homography is not None and mapping.pairs is not None:
        raise InputError(
            "either a homography or pairs to fit one", "both", field="projection.homography"
        )
    if mapping.homography is not None:
        matrix = np.array(mapping.homography, dtype=np.float64)
        if not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-300:
            raise InputError(
                "an invertible 3×3 matrix", matrix.tolist(), field="projection.homography"
            )
        return Projection(basis, origin, matrix)
    if mapping.pairs is not None:
        for i, (_, pixel) in enumerate(mapping.pairs):
            if len(pixel) != 2:
                raise InputError("[u, v]", pixel, row=i, field="projection.pairs")
        world = np.concatenate(
            [flat.on_plane(np.array([source], dtype=np.float64)) for source, _ in mapping.pairs]
        )
        target = np.array([target for _, target in mapping.pairs], dtype=np.float64)
        matrix, residual = fit_homography(world[:, :2], target)
        return Projection(basis, origin, matrix, residual)
    return flat


def _plane(plane: str | PlaneMapping) -> tuple[FloatArray, FloatArray]:
    if isinstance(plane, str):
        return np.eye(3)[list(_AXES[plane])], np.zeros(3)
    x, y = np.array(plane.x_axis, dtype=np.float64), np.array(plane.y_axis, dtype=np.float64)
    x_length = np.linalg.norm(x)
    if x_length == 0:
        raise InputError("an axis that is not zero", plane.x_axis, field="projection.plane.x_axis")
    x = x / x_length
    y = y - (y @ x) * x  # the y axis is made square to the x axis
    y_length = np.linalg.norm(y)
    if y_length < 1e-9:
        raise InputError("an axis across the x axis", plane.y_axis, field="projection.plane.y_axis")
    y = y / y_length
    return np.stack([x, y, np.cross(x, y)]), np.array(plane.origin, dtype=np.float64)
