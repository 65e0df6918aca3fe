"""Draws fields.png: vertical stretch and pore pressure at the peak of P2, in the deformed sample.

runner simulate P2 --fields /tmp/fields && python fields.py /tmp/fields/P2.pvd fields.png
(pip install pyvista, which brings VTK and matplotlib)
"""

import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pyvista
from matplotlib.collections import LineCollection
from matplotlib.patches import Rectangle

PUNCH, VIEW, DEPTH = 2.0, 5.0, 4.5  # mm
SIDES = ((0, 4, 1), (1, 5, 2), (2, 6, 3), (3, 7, 0))


def face_depth(mesh):
    """Depth of the punch's face (mm); 0 off contact."""
    touched = mesh.point_data["contact"] > 0
    return -1e3 * mesh.point_data["displacement_m"][touched, 2].mean() if touched.any() else 0.0


def peak(pvd):
    """The first frame at the largest depth, by VTK's own readers."""
    reader = pyvista.get_reader(pvd)
    best = (-1.0, None, None)
    for time in reader.time_values:
        reader.set_active_time_value(time)
        mesh = reader.read()[0]
        if face_depth(mesh) > best[0] + 1e-6:
            best = (face_depth(mesh), time, mesh)
    return best[1:]


def edges(mesh, height):
    """Deformed sides of the elements (mm): corner, mid-side point, corner."""
    points = 1e3 * (mesh.points + mesh.point_data["displacement_m"])[:, [0, 2]] - [0.0, height]
    cells = mesh.cells_dict[pyvista.CellType.BIQUADRATIC_QUAD]
    sides = {tuple(sorted((c[a], c[b]))): (c[a], c[m], c[b]) for c in cells for a, m, b in SIDES if c[a] != c[b]}
    # A parabola through three points.
    s = np.linspace(0, 1, 9)[:, None]
    shape = [(1 - s) * (1 - 2 * s), 4 * s * (1 - s), s * (2 * s - 1)]
    return [sum(n * points[k] for n, k in zip(shape, side)) for side in sides.values()]


def triangles(mesh):
    """Deformed triangles: the quadratic cells split for drawing."""
    mesh = mesh.warp_by_vector("displacement_m")
    return mesh.extract_surface(nonlinear_subdivision=3, algorithm="dataset_surface").triangulate()


def main(pvd, picture):
    time, mesh = peak(pvd)
    surface = triangles(mesh)
    height = 1e3 * mesh.points[:, 2].max()
    r, z = 1e3 * surface.points[:, 0], 1e3 * surface.points[:, 2] - height
    faces = surface.faces.reshape(-1, 4)[:, 1:]
    stretch, pressure = (surface.point_data[name] for name in ("vertical_stretch", "pore_pressure_Pa"))

    plt.rcParams.update({"font.size": 10, "font.family": "DejaVu Sans"})
    figure, axes = plt.subplots(figsize=(8.6, 6.2), layout="constrained")
    # Beyond this range lies only the singular edge.
    left = axes.tripcolor(-r, z, faces, stretch, shading="gouraud", cmap="RdBu", vmin=0.7, vmax=1.3)
    top = np.ceil(pressure.max() / 50) * 50
    right = axes.tripcolor(r, z, faces, pressure, shading="gouraud", cmap="viridis", vmin=0, vmax=top)
    for side, colour in ((-1, "k"), (1, "w")):
        lines = [np.column_stack([side * line[:, 0], line[:, 1]]) for line in edges(mesh, height)]
        axes.add_collection(LineCollection(lines, colors=colour, linewidths=0.4, alpha=0.35))

    depth = face_depth(mesh)
    axes.add_patch(Rectangle((-PUNCH, -depth), 2 * PUNCH, 2 * depth, facecolor="0.85", edgecolor="0.3", zorder=3))
    axes.text(0, -0.4 * depth, "punch", ha="center", va="center", zorder=4)
    axes.axvline(0, color="0.3", linewidth=0.8, linestyle="-.")
    axes.set(xlim=(-VIEW, VIEW), ylim=(-DEPTH, 0.7), aspect="equal", xlabel="radius r (mm)")
    axes.set_ylabel("height above the undeformed surface (mm)")
    axes.xaxis.set_major_formatter(lambda x, _: f"{abs(x):g}")
    axes.set_title(f"P2 at its peak: {depth:.1f} mm deep after {time:.2f} s, deformed to scale")
    bars = {"location": "bottom", "shrink": 0.9, "aspect": 30, "pad": 0.02}
    figure.colorbar(right, ax=axes, label="right: pore pressure (Pa)", **bars)
    figure.colorbar(left, ax=axes, extend="both", label="left: vertical stretch (-), red where shortened", **bars)
    figure.savefig(picture, dpi=130)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
