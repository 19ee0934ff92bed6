"""Writing ONNX that OpenCV DNN loads, and proving that it computes the same."""

import os
import sys

import cv2
import numpy as np
import torch

OPSET = 11  # the oldest whose Resize knows align_corners=false; the networks hold no ReLU6, which OpenCV 4.6 refuses
TOLERANCE = 1e-3


def export(model, width, height, path, largest_bytes, sample, names=("output",)):
    """Writes `model`, whose outputs get `names`, and compares OpenCV's with torch's on `sample` (1, 3, H, W); exits
    when they differ."""
    model.eval()
    with torch.no_grad():
        wanted = model(sample)
        wanted = [y.numpy() for y in (wanted if isinstance(wanted, tuple) else (wanted,))]
        torch.onnx.export(model, torch.zeros(1, 3, height, width), path, opset_version=OPSET, input_names=["image"],
                          output_names=list(names), do_constant_folding=True)
    network = cv2.dnn.readNetFromONNX(path)
    network.setInput(sample.numpy())
    difference = 0.0
    for name, own in zip(names, wanted):
        got = network.forward(name)
        if got.size != own.size:
            sys.exit(f"error: OpenCV computes {got.shape} as {name} from {path}, torch {own.shape}")
        scale = max(1.0, float(np.abs(own).max()))
        difference = max(difference, float(np.abs(got.reshape(own.shape) - own).max()) / scale)
    size = os.path.getsize(path)
    if difference > TOLERANCE or size > largest_bytes:
        sys.exit(f"error: {path}: differs by {difference:.1e} (at most {TOLERANCE}), {size} of {largest_bytes} bytes")
    timer = cv2.TickMeter()
    for _ in range(10):
        timer.start()
        network.forward(list(names))
        timer.stop()
    parameters = sum(p.numel() for p in model.parameters())
    print(f"{path}: {parameters} parameters, {size / 1e6:.2f} MB, output {wanted[0].shape}, differs from torch by "
          f"{difference:.1e} of full scale, {timer.getTimeMilli() / 10:.0f} ms in OpenCV")
