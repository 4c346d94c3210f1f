# %% [markdown]
# # Fewer triangles
# How far a mesh may be reduced before it leaves its surface, and what even triangles cost.

# %%
import matplotlib.pyplot as plt
import numpy as np

import batten

mesh = batten.simulate("bumpycube", truth=True, truth_edge="2%").truth
print(mesh)

# %%
shares = [0.5, 0.75, 0.9, 0.95]
simplified = [batten.simplify(mesh, remove=share) for share in shares]
worst = [small.report["input_to_result"]["dmax"] for small in simplified]
for share, small, distance in zip(shares, simplified, worst):
    print(f"{share:.0%} removed: {len(small.triangles)} triangles, within {100 * distance:.3f} % of the diameter")

# %%
even = batten.remesh(mesh, vertices=len(simplified[-1].positions), adaptivity=0.5)


def smallest_angles(V, F):
    """Of every triangle, degrees."""
    sides = [V[F[:, (i + 1) % 3]] - V[F[:, i]] for i in range(3)]
    angles = []
    for i in range(3):
        a, b = sides[i], -sides[i - 1]
        cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    return np.min(angles, axis=0)


# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5))
left.loglog([len(small.triangles) for small in simplified], 100 * np.array(worst), "o-")
left.set(xlabel="triangles", ylabel="largest distance, % of the diameter")
for name, made in {"simplified": simplified[-1], "remeshed": even}.items():
    right.hist(smallest_angles(*made), np.linspace(0, 60, 31), histtype="step", label=name)
right.set(xlabel="smallest angle, degrees", ylabel="triangles")
right.legend(loc="upper left")
figure.tight_layout()
figure.savefig("fewer_triangles.png", dpi=100)
assert worst == sorted(worst)
