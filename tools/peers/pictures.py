"""Compares a picture of ours with replicas of a peer's, and shows both."""

import json
import math
import sys
from pathlib import Path

# A file here has the name of the package that reads EXR.
sys.path[:] = [folder for folder in sys.path if Path(folder or ".").resolve() != Path(__file__).resolve().parent]

import numpy as np
import mitsuba as mi

if not mi.variant():
    mi.set_variant("scalar_rgb")

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def read(path):
    """RGB of an EXR, and the standard error of its mean luminance relative to it if it is ours and says."""
    bitmap = mi.Bitmap(str(path))
    values = np.array(bitmap, dtype=float)
    channels = {field.name: values[:, :, i] for i, field in enumerate(bitmap.struct_())}
    image = np.stack([channels[c] for c in "RGB"], axis=-1)
    metadata = bitmap.metadata()
    if "ergodic.total_variance" in metadata:
        return image, math.sqrt(float(metadata["ergodic.total_variance"])) / (image @ LUMINANCE).mean()
    return image, None


def write(stem, image, exposed):
    """STEM.exr, and STEM.png with the exposure of another picture."""
    Path(stem).parent.mkdir(parents=True, exist_ok=True)
    mi.Bitmap(image.astype(np.float32)).write(f"{stem}.exr")
    scale = 0.18 / np.exp(np.log(np.maximum(exposed @ LUMINANCE, 1e-4)).mean())
    x = np.maximum(image * scale, 0)
    x = x / (1 + x @ LUMINANCE)[..., None] * 1.3
    srgb = np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)
    mi.Bitmap((np.clip(srgb, 0, 1) * 255).astype(np.uint8)).write(f"{stem}.png")


def blocks(luminance, rows, columns):
    return np.array([[b.mean() for b in np.array_split(row, columns, axis=1)] for row in np.array_split(luminance, rows)])


def compare(path, replicas, facts, stem=None, rows=6, columns=8):
    """Prints how our picture differs from the mean of a peer's replicas, and writes STEM.json and pictures."""
    ours, our_error = read(path)
    theirs = replicas.mean(axis=0)
    if ours.shape != theirs.shape:
        raise SystemExit(f"{path} is {ours.shape[1]}x{ours.shape[0]}, the peer's picture is {theirs.shape[1]}x{theirs.shape[0]}")
    n = len(replicas)
    means = (replicas @ LUMINANCE).mean(axis=(1, 2))
    their_error = means.std(ddof=1) / math.sqrt(n) / means.mean() if n > 1 else None
    our_blocks = blocks(ours @ LUMINANCE, rows, columns)
    each = np.array([blocks(replica @ LUMINANCE, rows, columns) for replica in replicas])
    their_blocks = each.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        difference = our_blocks / their_blocks - 1
        block_error = each.std(axis=0, ddof=1) / math.sqrt(n) / their_blocks if n > 1 else np.full_like(difference, np.nan)
    result = facts | {
        "ours": str(path),
        "mean_ours": [*ours.mean(axis=(0, 1))],
        "mean_theirs": [*theirs.mean(axis=(0, 1))],
        "ratio_rgb": [*(ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1)))],
        "ratio_luminance": float((ours @ LUMINANCE).mean() / (theirs @ LUMINANCE).mean()),
        "error_ours": our_error,
        "error_theirs": their_error,
        "block_difference": difference.tolist(),
        "block_error_theirs": block_error.tolist(),
        "luminance_weighted_block_difference": float(np.abs(our_blocks - their_blocks).sum() / their_blocks.sum()),
    }
    percent = lambda x: "unknown" if x is None else f"{100 * x:.2f} %"
    print(f"ours over {facts['peer']}: R G B {' '.join(f'{x:.4f}' for x in result['ratio_rgb'])}, "
          f"luminance {result['ratio_luminance']:.4f}; standard errors {percent(our_error)} and {percent(their_error)}")
    print(f"blocks, ours less theirs in % (mean of absolute values {100 * result['luminance_weighted_block_difference']:.2f}; "
          f"median standard error of theirs {100 * np.nanmedian(block_error):.2f}):")
    for row in difference:
        print("  " + " ".join(f"{100 * x:7.2f}" for x in row))
    if stem:
        write(stem, theirs, ours)
        write(f"{stem}.ours", ours, ours)
        Path(f"{stem}.json").write_text(json.dumps(result, indent=1))
    return result
