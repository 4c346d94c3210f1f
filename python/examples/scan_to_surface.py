# %% [markdown]
# # From a scan to a surface
# A device slid along the curves of an object, and its readings became a surface that knows how sure it is.

# %%
import matplotlib.pyplot as plt
import numpy as np

import batten

scan = batten.read_rawnet("sample.rawnet")  # data/sample.rawnet
print(scan)

# %%
surface = batten.reconstruct(scan, edge_length="3%", uncertainty=True)
network = surface.network
figures = surface.report
print(surface, "watertight:", figures["watertight"], "genus:", figures["genus"])
print("curves close within", figures["network"]["closure_misfit"], "where the readings had",
      figures["network"]["closure_misfit_before"])  # fmt: skip
batten.write_mesh("surface.ply", surface)

# %%
figure = plt.figure(figsize=(9, 4.5))
left = figure.add_subplot(1, 2, 1, projection="3d", title="curves and surface")
left.plot_trisurf(*surface.positions.T, triangles=surface.triangles, color="lightsteelblue", alpha=0.6, linewidth=0, antialiased=False)
for curve in network.curves:
    left.plot(*network.positions[curve].T, color="darkred", linewidth=1)
right = figure.add_subplot(1, 2, 2, projection="3d", title="standard deviation")
drawn = right.plot_trisurf(*surface.positions.T, triangles=surface.triangles, cmap="viridis", linewidth=0, antialiased=False)
drawn.set_array(surface.uncertainty[surface.triangles].mean(axis=1))
figure.colorbar(drawn, ax=right, shrink=0.6, pad=0.1, label="in the unit of the scan")
for axes in (left, right):
    axes.set_box_aspect(np.ptp(surface.positions, axis=0), zoom=1.3)
    axes.set_axis_off()
figure.tight_layout()
figure.savefig("scan_to_surface.png", dpi=80)
