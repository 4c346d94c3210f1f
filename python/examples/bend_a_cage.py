# %% [markdown]
# # A cage, refined and bent
# Eight corners become a rounded bar with one sharp edge, which handles then twist.

# %%
import matplotlib.pyplot as plt
import numpy as np

import batten

corners = np.array([[x, y, z] for x in (0, 4) for y in (0, 1) for z in (0, 1)], dtype=float)
faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
cage = batten.Cage(corners, faces, sharp_edges={(0, 4): np.inf})
bar = batten.subdivide(cage, levels=4, limit=True)
print(bar)

# %%
mesh = batten.remesh(bar.mesh(), vertices=2000)
x = mesh.positions[:, 0]
bent = batten.deform(
    mesh,
    handles={
        "fixed": {"vertices": np.flatnonzero(x < np.quantile(x, 0.1))},
        "handles": [
            {
                "select": {"vertices": np.flatnonzero(x > np.quantile(x, 0.9))},
                "translate": [0, 0, 1],
                "rotate_deg": [1, 0, 0, 90],
                "about": [4, 0.5, 0.5],
            }
        ],
    },
)
print(bent.report["iterations"], "iterations")

# %%
figure = plt.figure(figsize=(9, 4))
for place, (name, made) in enumerate({"refined": bar.mesh(), "bent": bent}.items()):
    axes = figure.add_subplot(1, 2, place + 1, projection="3d", title=name)
    axes.plot_trisurf(*made.positions.T, triangles=made.triangles, color="cadetblue", edgecolor="white", linewidth=0.1)
    axes.set_box_aspect(np.ptp(bent.positions, axis=0), zoom=1.3)
    axes.set_axis_off()
figure.tight_layout()
figure.savefig("bend_a_cage.png", dpi=100)
