"""Reading what make_dataset wrote, and making pictures harder."""

import json
import os
import pathlib
import sys

import cv2
import numpy as np

cv2.setNumThreads(1)
MEAN = np.array([0.485, 0.456, 0.406], np.float32)
STD = np.array([0.229, 0.224, 0.225], np.float32)
VALIDATION_EVERY = 20  # scenes whose seed is a multiple of it are held out
FIRST_TRAINING_SEED = 1_000_000


def default_folder():
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return os.path.join(cache, "frugal_nav", "dataset")


FLOOR_HEIGHT = 0.015  # [m]; what is lower counts as floor


def floor_of(depth_mm, label):
    """Where a picture shows the floor: (H, W) uint8, 255 or 0, by the height of each pixel's point."""
    height, width = depth_mm.shape
    camera = label["camera"]
    matrix = np.array([[camera["fx"], 0.0, camera["cx"]], [0.0, camera["fy"], camera["cy"]], [0.0, 0.0, 1.0]])
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1).reshape(-1, 1, 2).astype(np.float64)
    rays = cv2.undistortPoints(pixels, matrix, np.array(label["distortion"])).reshape(height, width, 2)
    pitch = label["pitch_rad"]  # up is positive
    rise = np.sin(pitch) - np.cos(pitch) * rays[..., 1]  # of a point at depth one, over the camera
    above_floor = label["camera_height_m"] + 0.001 * depth_mm * rise
    return np.where((depth_mm > 0) & (np.abs(above_floor) < FLOOR_HEIGHT), 255, 0).astype(np.uint8)


class Pictures:
    """All images of a folder in memory, at one size: bgr (N, H, W, 3) uint8, labels, and on request inverse
    depth (N, H, W) float16 [1/m] and floor (N, H, W) uint8, 255 where all of a pixel shows it."""

    def __init__(self, folder, size, with_depth):
        folder = pathlib.Path(folder)
        self.names = sorted(path.stem for path in (folder / "labels").glob("*.json"))
        if not self.names:
            sys.exit(f"error: no labels in {folder}: make them with `rosrun frugal_nav make_dataset --out {folder}`")
        self.labels = [json.loads((folder / "labels" / f"{name}.json").read_text()) for name in self.names]
        wrong = [label["seed"] for label in self.labels if label["seed"] < FIRST_TRAINING_SEED]
        if wrong:
            sys.exit(f"error: seed {wrong[0]} is not a training seed (from {FIRST_TRAINING_SEED} on)")
        width, height = size
        self.bgr = np.empty((len(self.names), height, width, 3), np.uint8)
        self.inverse_depth = np.empty((len(self.names), height, width), np.float16) if with_depth else None
        self.floor = np.empty((len(self.names), height, width), np.uint8) if with_depth else None
        for i, name in enumerate(self.names):
            image = cv2.imread(str(folder / "images" / f"{name}.jpg"))
            self.bgr[i] = image if image.shape[1] == width else cv2.resize(image, size, interpolation=cv2.INTER_AREA)
            if with_depth:
                depth_mm = cv2.imread(str(folder / "depth" / f"{name}.png"), cv2.IMREAD_UNCHANGED)
                self.floor[i] = cv2.resize(floor_of(depth_mm, self.labels[i]), size, interpolation=cv2.INTER_AREA)
                depth_mm = cv2.resize(depth_mm, size, interpolation=cv2.INTER_NEAREST)
                self.inverse_depth[i] = 1000.0 / np.maximum(depth_mm, 150)
        held_out = np.array([label["seed"] % VALIDATION_EVERY == 0 for label in self.labels])
        self.training = np.flatnonzero(~held_out)
        self.validation = np.flatnonzero(held_out)


class Order:
    """Which pictures a training step takes: every picture once in each shuffled round; the same for the same
    seed, wherever training is resumed."""

    def __init__(self, indices, batch, seed):
        self.indices, self.batch, self.seed = indices, batch, seed

    def at(self, step):
        steps_a_round = max(1, len(self.indices) // self.batch)
        shuffled = np.random.default_rng((self.seed, step // steps_a_round)).permutation(self.indices)
        first = (step % steps_a_round) * self.batch
        return shuffled[first : first + self.batch]


def disturb(bgr, rng):
    """Other light, colours, sharpness and noise; uint8 in, float32 in [0, 255] out."""
    levels = np.repeat(np.linspace(0.0, 1.0, 256)[:, None], 3, axis=1)
    if rng.random() < 0.8:
        levels = levels * np.exp(rng.normal(0.0, 0.18)) * np.exp(rng.normal(0.0, 0.07, 3)) + rng.normal(0.0, 0.03)
    if rng.random() < 0.5:
        levels = np.clip(levels, 0.0, 1.0) ** np.exp(rng.normal(0.0, 0.25))
    image = cv2.LUT(np.ascontiguousarray(bgr), np.clip(255.0 * levels, 0, 255).astype(np.uint8)[None])
    if rng.random() < 0.5:
        colour = rng.uniform(0.0, 1.6)
        image = cv2.transform(image, colour * np.eye(3) + (1.0 - colour) / 3.0)
    if rng.random() < 0.25:
        image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.3, 1.2))
    elif rng.random() < 0.1:
        length = int(rng.integers(3, 8))
        kernel = np.full((1, length), 1.0 / length, np.float32)
        image = cv2.filter2D(image, -1, kernel if rng.random() < 0.8 else kernel.T)
    image = image.astype(np.float32)
    if rng.random() < 0.4:
        image += rng.standard_normal(image.shape, np.float32) * np.float32(rng.uniform(1.0, 12.0))
    return np.clip(image, 0.0, 255.0)
