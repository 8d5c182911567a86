# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a flight."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402


def _scatter(axes, points, label, size=1.0):
    if not len(points):
        return
    order = np.argsort(points[:, 2])
    points = points[order]
    image = axes.scatter(points[:, 0], points[:, 1], c=points[:, 2], s=size, cmap="viridis", linewidths=0,
                         rasterized=True, label=label)
    plt.colorbar(image, ax=axes, label="height [m]", shrink=0.7)


def top_view(path, record, trunks=None):
    """Map, obstacles and path from above.

    trunks: (n, 3) x y radius in metres of the simulated world's trunks, drawn as truth, or None.
    """
    figure, axes = plt.subplots(figsize=(14, 8))
    points = record.obstacle_points
    # What stands in the way of a level flight; ground and canopy would cover the picture.
    flown = record.truth[1]
    if len(points) and len(flown):
        level = np.median(flown[:, 2])
        points = points[np.abs(points[:, 2] - level) < 1.5]
    _scatter(axes, points, "obstacles near flight level", 3.0)
    if trunks is not None:
        for x, y, radius in trunks:
            axes.add_patch(plt.Circle((x, y), max(radius, 0.1), color="saddlebrown", zorder=3))
    for track, colour, label in ((record.odometry, "tab:orange", "odometry"),
                                 (record.optimised, "tab:blue", "optimised"), (record.truth, "black", "true path")):
        if len(track[0]):
            axes.plot(track[1][:, 0], track[1][:, 1], color=colour, linewidth=1.5, label=label, zorder=4)
    if record.goal is not None:
        axes.plot(record.goal[0], record.goal[1], "r*", markersize=16, label="goal", zorder=5)
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.set_title("%s, seed %s: %s" % (record.world, record.seed, record.reason))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left")
    axes.grid(alpha=0.3)
    figure.savefig(path, dpi=110, bbox_inches="tight")
    plt.close(figure)
