"""The convolutional trunk of both networks: plain 3x3 convolutions and ReLU, which OpenCV DNN runs fast and loads
in every version from 4.2 on; most of the work is at low resolution."""

import torch.nn as nn


def conv(inputs, outputs, size=3, stride=1):
    """Convolution, batch norm (folded into the convolution on export), ReLU."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, size, stride, size // 2, bias=False), nn.BatchNorm2d(outputs), nn.ReLU(inplace=True)
    )


class Residual(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.first = conv(channels, channels)
        self.second = nn.Sequential(nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels))
        self.relu = nn.ReLU(inplace=True)

    def forward(self, x):
        return self.relu(x + self.second(self.first(x)))


class Backbone(nn.Module):
    """Features at strides 2, 4, 8, ... with the given channels; `blocks` residual blocks follow each stride."""

    def __init__(self, channels, blocks):
        super().__init__()
        before = (3,) + tuple(channels[:-1])
        self.stages = nn.ModuleList(
            nn.Sequential(conv(i, o, stride=2), *(Residual(o) for _ in range(n)))
            for i, o, n in zip(before, channels, blocks)
        )

    def forward(self, x):
        features = []
        for stage in self.stages:
            x = stage(x)
            features.append(x)
        return features
