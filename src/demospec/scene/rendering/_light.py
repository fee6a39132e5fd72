"""Light of a scene: shading of sprites, and soft shadows on the table."""

from __future__ import annotations

import math

import numpy as np

from demospec.frames import FloatArray
from demospec.scene._recipe import Light
from demospec.scene.rendering._sprites import F32, SAMPLES, Sprite


def draw_light(rng: np.random.Generator) -> Light:
    """A lamp somewhere above the table, 57° to 77° high: shadows of up to 0.65 of the height."""
    return Light(
        azimuth=round(float(rng.uniform(-math.pi, math.pi)), 4),
        elevation=round(float(rng.uniform(1.0, 1.35)), 4),
        strength=round(float(rng.uniform(0.86, 1.05)), 4),
        ambient=round(float(rng.uniform(0.38, 0.6)), 4),
        warmth=round(float(rng.uniform(-0.04, 0.07)), 4),
        softness=round(float(rng.uniform(0.1, 0.25)), 4),
    )


def direction(light: Light) -> FloatArray:
    """(3,) unit vector towards the light; x right, y down in the picture, z to the viewer."""
    flat = math.cos(light.elevation)
    return np.array(
        [
            flat * math.cos(light.azimuth),
            flat * math.sin(light.azimuth),
            math.sin(light.elevation),
        ]
    )


def colour(light: Light) -> FloatArray:
    """(3,) what white looks like where the light falls square on the table."""
    return light.strength * np.array([1 + light.warmth, 1.0, 1 - light.warmth])


def falloff(light: Light, size_px: tuple[int, int]) -> FloatArray:
    """(height, width, 1): the side of the table near the lamp is up to 7 % brighter."""
    width, height = size_px
    x = (np.arange(width) + 0.5) / width - 0.5
    y = (np.arange(height) + 0.5) / height - 0.5
    flat = direction(light)[:2]
    slope = x[None, :] * flat[0] + y[:, None] * flat[1]
    round_ = x[None, :] ** 2 + y[:, None] ** 2
    return np.asarray((1.0 + 0.25 * slope - 0.12 * round_)[..., None])


def shaded(sprite: Sprite, light: Light) -> FloatArray:
    """(h, w, 3) light that the sprite sends to the viewer, premultiplied, 1 = white."""
    lamp = direction(light)
    facing = np.maximum(sprite.normal @ lamp, 0.0) / lamp[2]
    shade = light.ambient + (1.0 - light.ambient) * facing
    # Crevices see less of the sky: a cheap stand-in for ambient occlusion.
    shade = shade * (0.72 + 0.28 * sprite.normal[..., 2])
    half = lamp + np.array([0.0, 0.0, 1.0])
    half /= np.linalg.norm(half)
    glint = np.maximum(sprite.normal @ half, 0.0) ** 48 * sprite.gloss * 0.45
    out = sprite.albedo * shade[..., None] + glint[..., None]
    return np.asarray(out * colour(light))


def on_pixels(samples: FloatArray | F32, empty: float, phase: tuple[int, int]) -> FloatArray:
    """Box-averages a sample grid onto pixels after moving it `phase` (x, y) samples on."""
    h, w = samples.shape[:2]
    rest = samples.shape[2:]
    padded = np.full((h + SAMPLES, w + SAMPLES, *rest), empty, dtype=np.float32)
    padded[phase[1] : phase[1] + h, phase[0] : phase[0] + w] = samples
    shape = (h // SAMPLES + 1, SAMPLES, w // SAMPLES + 1, SAMPLES, *rest)
    return np.asarray(padded.reshape(shape).mean(axis=(1, 3)))


def shadow(
    veil: FloatArray, height_px: FloatArray, light: Light, px_scale: float
) -> tuple[FloatArray, int]:
    """Share of the lamp's light that an object takes from the table around it.

    The body is cut into layers; each layer's shadow is the layer moved away from the lamp by
    height / tan(elevation) and blurred by height · softness. The darkest layer counts.

    Args:
        veil: (h, w) how much each pixel of the object holds back, 0 … 1.
        height_px: (h, w) height of its surface, pixels.
        px_scale: Pixels at this picture size per pixel at 100.

    Returns:
        (occlusion (h + 2 m, w + 2 m) in [0, 1], margin m in pixels).
    """
    lamp = direction(light)
    away = -lamp[:2] / lamp[2]
    top = float(height_px.max())
    far = top * float(np.hypot(*away))
    soft = light.softness
    contact = 0.9 * px_scale
    layers = 2 + min(8, math.ceil(far / (1.5 * px_scale)))
    gap = far / (layers - 1)
    margin = math.ceil(far + 2.6 * max(contact, 0.5 * gap, soft * top) + 1)
    h, w = veil.shape
    out = np.zeros((h + 2 * margin, w + 2 * margin))
    for z in np.linspace(0.0, top, layers):
        layer = veil * np.clip((height_px - 0.92 * z) / max(0.08 * top, 1e-6), 0.0, 1.0)
        sigma = max(contact, soft * z, 0.5 * gap)
        across = _moved_blur(w, margin, float(away[0] * z), sigma)
        down = _moved_blur(h, margin, float(away[1] * z), sigma)
        np.maximum(out, down @ layer @ across.T, out=out)
    # Fade to exactly nothing at the margin, so that an overlay has a neighbourhood.
    return np.clip((out - 0.012) / 0.988, 0.0, 1.0), margin


def _moved_blur(n: int, margin: int, shift: float, sigma: float) -> FloatArray:
    """(n + 2 margin, n): moves by `shift` pixels and blurs by a Gaussian, in one matrix."""
    to = np.arange(-margin, n + margin)[:, None]
    of = np.arange(n)[None, :]
    kernel = np.exp(-0.5 * ((to - of - shift) / sigma) ** 2)
    return np.asarray(kernel / (sigma * math.sqrt(2 * math.pi)))
