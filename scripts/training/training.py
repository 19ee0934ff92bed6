"""The loop both trainings run: warm-up and cosine learning rate, checkpoints that resume, one table."""

import math
import os
import time

import numpy as np
import torch


def learning_rate(step, steps, peak, warm_up=200):
    if step < warm_up:
        return peak * (step + 1) / warm_up
    return peak * (0.01 + 0.99 * 0.5 * (1.0 + math.cos(math.pi * (step - warm_up) / max(1, steps - warm_up))))


def prepare(seed, threads):
    torch.manual_seed(seed)
    np.random.seed(seed)
    torch.use_deterministic_algorithms(True, warn_only=True)
    torch.set_num_threads(threads)


class Loop:
    """Runs `train_step(step) -> loss` and `validate() -> (score, columns)`; the best score is kept."""

    def __init__(self, model, checkpoint, steps, peak_rate, save_every, validate_every):
        self.model, self.checkpoint, self.steps, self.peak_rate = model, checkpoint, steps, peak_rate
        self.save_every, self.validate_every = save_every, validate_every
        self.optimizer = torch.optim.AdamW(model.parameters(), lr=peak_rate, weight_decay=1e-3)
        self.step, self.best = 0, math.inf
        # A running mean of the weights: steadier than the last ones, above all after a short training.
        self.mean = {name: value.detach().clone() for name, value in model.state_dict().items()}
        if os.path.exists(checkpoint):
            state = torch.load(checkpoint)
            model.load_state_dict(state["model"])
            self.optimizer.load_state_dict(state["optimizer"])
            self.step, self.best, self.mean = state["step"], state["best"], state["mean"]
            print(f"resumed at step {self.step} of {steps}", flush=True)

    def save(self):
        state = {"model": self.model.state_dict(), "optimizer": self.optimizer.state_dict(), "step": self.step}
        state.update(best=self.best, mean=self.mean)
        torch.save(state, self.checkpoint + ".new")
        os.replace(self.checkpoint + ".new", self.checkpoint)

    def update_mean(self):
        keep = min(0.998, self.step / (self.step + 50.0))
        for name, value in self.model.state_dict().items():
            if value.dtype.is_floating_point:
                self.mean[name].mul_(keep).add_(value.detach(), alpha=1.0 - keep)
            else:
                self.mean[name].copy_(value)

    def check(self, validate):
        """Scores the mean weights, and keeps them when they are the best so far."""
        trained = {name: value.clone() for name, value in self.model.state_dict().items()}
        self.model.load_state_dict(self.mean)
        self.model.eval()
        with torch.no_grad():
            score, columns = validate()
        if score < self.best:
            self.best = score
            torch.save(self.mean, self.best_file())
        self.model.load_state_dict(trained)
        return columns

    def best_file(self):
        return self.checkpoint.replace(".pt", "") + "_best.pt"

    def run(self, train_step, validate):
        began, losses = time.time(), []
        while self.step < self.steps:
            self.model.train()
            for group in self.optimizer.param_groups:
                group["lr"] = learning_rate(self.step, self.steps, self.peak_rate)
            self.optimizer.zero_grad(set_to_none=True)
            loss = train_step(self.step)
            loss.backward()
            torch.nn.utils.clip_grad_norm_(self.model.parameters(), 5.0)
            self.optimizer.step()
            losses.append(loss.item())
            self.step += 1
            self.update_mean()
            last = self.step == self.steps
            if self.step % self.validate_every == 0 or last:
                columns = self.check(validate)
                minutes = (time.time() - began) / 60.0
                print(f"step {self.step:6d}  loss {np.mean(losses):7.4f}  {columns}  {minutes:5.1f} min", flush=True)
                losses = []
            if self.step % self.save_every == 0 or last:
                self.save()
