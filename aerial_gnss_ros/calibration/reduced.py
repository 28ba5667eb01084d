# SPDX-License-Identifier: Apache-2.0
"""Normal equations of a recording from which each image's own errors are eliminated.

With unknowns u and own errors x_i of image i, boxes give J u + H_i x_i = r. The own errors of an
image meet those of no other, so that the Schur complement leaves equations in u alone, and with its
solution the own errors follow image by image.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.model import Residuals

Array = NDArray[np.float64]

HUBER = 2.5


@dataclass(frozen=True)
class Reduced:
    """One Gauss-Newton step's equations.

    Attributes:
        normal: (size, size) information on the unknowns; without their priors.
        gradient: (size,) likewise.
        by_unknowns: (images, 6, size) of the own errors' equations.
        spread: (images, 6, 6) covariances of the own errors if the unknowns were known.
        pull: (images, 6) gradients of the own errors.
    """

    normal: Array
    gradient: Array
    by_unknowns: Array
    spread: Array
    pull: Array

    def own_step(self, step: Array) -> Array:
        """Return the step (images, 6) of the own errors that goes with one of the unknowns."""
        left = self.pull - self.by_unknowns @ step
        return np.asarray(np.einsum("iab,ib->ia", self.spread, left))


def reduced(rows: Residuals, own: Array, variances: Array, pixel: float) -> Reduced:
    """Return the equations.

    Args:
        rows: residuals and derivatives with the own errors taken out of the poses.
        own: (images, 6) these errors.
        variances: (6,) of them.
        pixel: variance of a box's centre, px².
    """
    size = rows.jacobian.shape[2]
    weight = np.minimum(1.0, HUBER / np.maximum(distances(rows, pixel), 1e-9)) / pixel
    weighted = rows.jacobian * weight[:, None, None]
    flat = weighted.reshape(-1, size)
    normal = flat.T @ rows.jacobian.reshape(-1, size)
    gradient = flat.T @ rows.values.ravel()
    turned = rows.by_own.swapaxes(1, 2)
    information = np.tile(np.diag(1.0 / variances), (len(own), 1, 1))
    by_unknowns = np.zeros((len(own), 6, size))
    pull = -own / variances
    np.add.at(information, rows.images, weight[:, None, None] * turned @ rows.by_own)
    np.add.at(by_unknowns, rows.images, turned @ weighted)
    pulled = weight[:, None] * np.einsum("nap,np->na", turned, rows.values)
    np.add.at(pull, rows.images, pulled)
    spread = np.asarray(np.linalg.inv(information), dtype=np.float64)
    half = np.linalg.cholesky(spread).swapaxes(1, 2)
    lost = (half @ by_unknowns).reshape(-1, size)
    gradient -= lost.T @ (half @ pull[:, :, None]).ravel()
    return Reduced(normal - lost.T @ lost, gradient, by_unknowns, spread, pull)


def cost(rows: Residuals, own: Array, variances: Array, pixel: float) -> float:
    """Return what the residuals and the own errors cost: squares, Huber's beyond 2.5 sigma."""
    return huber(distances(rows, pixel)) + float(np.sum(own**2 / variances))


def distances(rows: Residuals, pixel: float) -> Array:
    """Return how many sigma of a box's centre the residuals are, (n,)."""
    found: Array = np.sqrt(np.sum(rows.values**2, axis=1) / pixel)
    return found


def whole_distances(rows: Residuals, own: Array, variances: Array, pixel: float) -> Array:
    """Return how many sigma of box and pose together the boxes are off, (n,)."""
    off = rows.values + np.einsum("npa,na->np", rows.by_own, own[rows.images])
    spread = (rows.by_own * variances) @ rows.by_own.swapaxes(1, 2) + pixel * np.eye(2)
    squared = np.einsum("np,np->n", off, np.linalg.solve(spread, off[:, :, None])[:, :, 0])
    return np.asarray(np.sqrt(squared))


def huber(distance: Array) -> float:
    """Return Huber's cost of normalised distances."""
    inner = np.minimum(distance, HUBER)
    return float(np.sum(inner * (2.0 * distance - inner)))
