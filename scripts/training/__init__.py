"""What scripts/train_depth and scripts/train_heads share."""
