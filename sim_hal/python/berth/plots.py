"""Pictures for notebooks, by matplotlib, which is needed for them alone."""
from __future__ import annotations

import numpy as np


def _new_axes(axes, count=1):
    if axes is not None:
        return axes
    import matplotlib.pyplot as plt
    return plt.subplots(count, 1, sharex=True, layout="constrained")[1]


def _label(key):
    """"object.mass_kg" as "object.mass (kg)"."""
    from . import _core
    unit = _core.unit(key)
    ending = "_" + key.rsplit(".", 1)[-1].partition("_")[2]
    for part in ("_N_per_m", "_N_s_per_m", "_kg", "_ms", "_Hz", "_m", "_N", "_s"):
        if ending.endswith(part):
            return f"{key.removesuffix(part)} ({unit})" if unit else key
    return f"{key} ({unit})" if unit else key


def plot_spectrum(spectrum, axes=None):
    axes = _new_axes(axes)
    axes.add_patch(__import__("matplotlib.patches").patches.Circle((0, 0), 1, fill=False, color="0.6"))
    unstable = np.abs(spectrum.z) >= 1.0
    axes.plot(spectrum.z[~unstable].real, spectrum.z[~unstable].imag, "o", color="#1a7f37", label="|z| < 1")
    if unstable.any():
        axes.plot(spectrum.z[unstable].real, spectrum.z[unstable].imag, "x", color="#cf222e", label="|z| >= 1")
    axes.set(xlabel="Re z", ylabel="Im z", aspect="equal", title=f"growth {spectrum.growth_per_s:+.3g} /s")
    axes.legend(loc="lower left")
    return axes


def plot_map(found, axes=None):
    axes = _new_axes(axes)
    values = np.ma.masked_invalid(found.growth_per_s)
    reach = float(np.percentile(np.abs(values.compressed()), 95)) if values.count() else 1.0
    mesh = axes.pcolormesh(found.x, found.y, values, cmap="RdBu_r", vmin=-reach, vmax=reach, shading="nearest")
    axes.figure.colorbar(mesh, ax=axes, label="growth (1/s), stable below 0", extend="both")
    if values.count() and values.min() < 0.0 < values.max():
        axes.contour(found.x, found.y, values, levels=[0.0], colors="k")
    if found.x.min() <= found.own[0] <= found.x.max() and found.y.min() <= found.own[1] <= found.y.max():
        axes.plot(*found.own, "k*", markersize=12, label="the rig itself")
        axes.legend(loc="upper right")
    axes.set(xlabel=_label(found.x_key), ylabel=_label(found.y_key))
    return axes


def plot_ticks(run, axes=None):
    axes = _new_axes(axes, 2)
    for name in ("manipulator_position_m", "robot_position_m"):
        axes[0].plot(run.time_s, 1e3 * run[name], label=name.removesuffix("_position_m"))
    axes[0].set(ylabel="position (mm)")
    axes[0].legend(loc="upper right")
    axes[1].plot(run.time_s, run["force_N"], color="0.2")
    axes[1].set(ylabel="measured force (N)", xlabel="time (s)")
    return axes


def plot_diagnosis(found, axes=None):
    axes = np.atleast_1d(_new_axes(axes, len(found.blocks)))
    for block, one in zip(found.blocks, axes):
        one.plot(found.signals["time_s"], block.error_before, color="0.7", label="as given")
        one.plot(found.signals["time_s"], block.error_after, color="#0969da", label="extended")
        one.set(ylabel=f"error of {block.block} ({block.unit})")
        one.legend(loc="upper right")
    axes[-1].set(xlabel="time (s)")
    return axes
