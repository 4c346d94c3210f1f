# %% [markdown]
# # Drag curves, the surface follows
# A SurfaceSolver builds the surface of a network once and solves again for moved curves: fast enough for a slider.

# %%
import time

import matplotlib.pyplot as plt
import numpy as np

import batten

network = batten.simulate("dish", truth_network=True, truth_step="1.5%").truth_network
solver = batten.SurfaceSolver(network, edge_length="3%")
print(len(solver.positions), "vertices;", len(network.curves), "curves")

# %%
# A bump is pushed into the middle, wherever a curve passes; the border stays, and normals keep their directions.
border = np.concatenate([network.curves[c] for c, is_border in enumerate(network.boundary) if is_border])
middle = network.positions.mean(axis=0)
bump = np.exp(-(np.linalg.norm((network.positions - middle)[:, :2], axis=1) ** 2) / 0.1)
bump[border] = 0
heights = np.linspace(0, 0.4, 6)
middles, seconds = [], []
for height in heights:
    positions = network.positions.copy()
    positions[:, 2] += height * bump
    began = time.perf_counter()
    solver.move(positions, network.normals, reach="all")
    seconds.append(time.perf_counter() - began)
    middles.append(solver.positions)
print(f"a move takes {1000 * np.median(seconds):.1f} ms")

# %%
figure = plt.figure(figsize=(9, 3.4))
for place, step in enumerate((0, len(heights) - 1)):
    axes = figure.add_subplot(1, 2, place + 1, projection="3d", title=f"height {heights[step]:.2f}")
    X = middles[step]
    axes.plot_trisurf(*X.T, triangles=solver.triangles, color="wheat", linewidth=0, antialiased=False)
    for curve in network.curves:
        axes.plot(*X[curve].T, color="darkred", linewidth=1)
    axes.set_box_aspect(np.ptp(middles[-1], axis=0), zoom=1.4)
    axes.set_axis_off()
figure.tight_layout()
figure.savefig("drag_a_curve.png", dpi=90)
assert np.abs(middles[0] - solver.positions)[:, 2].max() > 0.3
