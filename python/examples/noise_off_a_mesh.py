# %% [markdown]
# # Noise off a mesh
# Every vertex of a torus is moved at random; fair() takes that off again without being told how much it was.

# %%
import matplotlib.pyplot as plt
import numpy as np

import batten

truth = batten.simulate("torus", truth=True, truth_edge="1.5%").truth
V, F = truth
edge = np.linalg.norm(V[F[:, 0]] - V[F[:, 1]], axis=1).mean()
noisy = V + np.random.default_rng(1).normal(0, 0.2 * edge, V.shape)

# %%
before = batten.compare((noisy, F), truth, samples=20000)
ways = {way: batten.fair(noisy, F, method=way) for way in ("auto", "taubin", "mcf")}
after = {way: batten.compare(faired, truth, samples=20000) for way, faired in ways.items()}
report = ways["auto"].report
print(f"noise: {report['noise']:.3f} mean edges found, 0.2 given; {report['strategy']}")
for way, found in after.items():
    print(f"{way}: mean distance {found.report['a_to_b']['mean']:.4f} of {before.report['a_to_b']['mean']:.4f}")

# %%
figure, axes = plt.subplots(figsize=(6, 4))
bins = np.linspace(0, 3 * before.distances.mean(), 60)
axes.hist(before.distances, bins, histtype="step", color="grey", label="with noise")
for way, found in after.items():
    axes.hist(found.distances, bins, histtype="step", label=way)
axes.set(xlabel="distance of a vertex from the truth", ylabel="vertices")
axes.legend()
figure.tight_layout()
figure.savefig("noise_off_a_mesh.png", dpi=100)
assert after["auto"].report["a_to_b"]["mean"] < 0.5 * before.report["a_to_b"]["mean"]
