#!/usr/bin/env python3
"""Draws sketching sessions as hands do, plays them and counts how many become sound and complete models.

Every object is a list of edits over exact curves. A hand adds tremor (smooth over some 7 % of a stroke, with a
little that is not; its root mean square in space is the given share of the object's diagonal) and lets strokes begin
and end too early or too late, by a normal deviate of the given share of the diagonal. Seeds make hands.

    experiments/drawing_hands.py write OUT_DIR --tremor 0.002 --off 0.003 --seed 1 [--objects mug,saddle]
    experiments/drawing_hands.py judge build/release/bin/batten [--hands 1,2] [--objects …] [--method v2] [--levels 2]

A session is complete when no edit is refused and the model has as many faces as the exact one, sound when the
program exits with 0 and finds no crossing and no turned triangle.
"""
import argparse
import concurrent.futures
import json
import math
import os
import random
import subprocess
import tempfile


def line(a, b):
    return lambda t: [a[k] + t * (b[k] - a[k]) for k in range(3)]


def circle(centre, u, v, radius, height=None):
    """Around `centre` in the plane of u and v."""
    height = radius if height is None else height

    def at(t):
        c, s = radius * math.cos(2 * math.pi * t), height * math.sin(2 * math.pi * t)
        return [centre[k] + c * u[k] + s * v[k] for k in range(3)]

    return at


def through(points):
    """A Catmull-Rom curve through points, evenly in their number."""
    n = len(points) - 1

    def at(t):
        i = min(int(t * n), n - 1)
        s = t * n - i
        p = [points[max(i - 1, 0)], points[i], points[i + 1], points[min(i + 2, n)]]
        if i == 0:
            p[0] = [2 * p[1][k] - p[2][k] for k in range(3)]
        if i == n - 1:
            p[3] = [2 * p[2][k] - p[1][k] for k in range(3)]
        return [
            0.5
            * (
                2 * p[1][k]
                + (p[2][k] - p[0][k]) * s
                + (2 * p[0][k] - 5 * p[1][k] + 4 * p[2][k] - p[3][k]) * s * s
                + (3 * p[1][k] - p[0][k] - 3 * p[2][k] + p[3][k]) * s**3
            )
            for k in range(3)
        ]

    return at


def stroke(curve, closed=False, n=81):
    n = 90 if closed else n
    return {"curve": curve, "closed": closed, "n": n}


def insert(curve, closed=False, n=81, **more):
    return dict(op="insert", stroke=stroke(curve, closed, n), **more)


def hole(curve, **more):
    return dict(op="hole", stroke=stroke(curve, True), **more)


def glue(first, second):
    return dict(op="glue", first=stroke(first), second=stroke(second))


def skin(profiles, spines):
    return dict(op="skin", profiles=[stroke(p, True) for p in profiles], spines=[stroke(s) for s in spines])


X, Y, Z = (1, 0, 0), (0, 1, 0), (0, 0, 1)


def body(radius, heights, angles=(0, math.pi)):
    """A body of revolution by skin, and its meridian at any angle."""

    def meridian(angle):
        c, s = math.cos(angle), math.sin(angle)
        z0, z1 = heights[0], heights[-1]

        def at(t):
            z = z0 + t * (z1 - z0)
            return [c * radius(z), s * radius(z), z]

        return at

    return skin([circle((0, 0, z), X, Y, radius(z)) for z in heights], [meridian(a) for a in angles]), meridian


def lid(radius, z, angle=math.pi / 2):
    c, s = math.cos(angle), math.sin(angle)
    return insert(line([radius * c, radius * s, z], [-radius * c, -radius * s, z]), n=31)


def sharp(curve):
    return {"op": "sharpness", "curve": curve, "value": 1}


def on_body(radius, angle, z, width, height):
    """A closed curve around a place on a body of revolution."""

    def at(t):
        h = z + height * math.sin(2 * math.pi * t)
        r = radius(h)
        a = angle + width * math.cos(2 * math.pi * t) / radius(z)
        return [r * math.cos(a), r * math.sin(a), h]

    return at


def saddle():
    def half(y):  # width of the seat
        return 0.2 + 1.8 * min(1, max(0, (y + 12.9) / 3)) ** 0.5 + 2.2 * (1 + math.tanh((y - 4.5) / 3.2))

    def edge(y):
        return -0.3 - 0.5 * half(y) + 0.02 * y

    def top(y):
        return 0.35 + 0.004 * (y - 0) ** 2

    def outline(t):
        # along one side and back along the other; the ends are round
        a = 2 * math.pi * t
        y = -12.9 * math.cos(a) if True else 0
        w = half(y) * (abs(math.sin(a)) ** 0.7) * (1.2 if y > 0 else 1.0)
        return [math.copysign(w, math.sin(a)), y, edge(y) * abs(math.sin(a)) ** 0.5]

    def place(y):
        a = math.acos(-y / 12.9)
        return outline(a / (2 * math.pi))

    def rib(y):
        w, _, z = place(y)

        def at(t):
            s = 2 * t - 1
            return [w * s, y, z + (top(y) - z) * (1 - s * s) ** 0.8 if abs(s) < 1 else z]

        return at

    def spine(t):
        y = -12.9 + 25.8 * t
        blend = (1 - (y / 12.9) ** 2) ** 0.6 if abs(y) < 12.9 else 0
        return [0, y, top(y) * blend]

    return [insert(outline, True), insert(spine)] + [insert(rib(y)) for y in (-8, -2, 4, 9)], (13, 26, 4)


def lamp():
    skinned, meridian = body(lambda z: 20 - 12 * z / 25, [0, 25])
    return [skinned, insert(meridian(math.pi / 2)), insert(meridian(-math.pi / 2))], (40, 40, 25)


def mug():
    def radius(z):
        return 4 + 0.15 * math.sin(math.pi * z / 8) - 0.002 * z * z * (z / 9.5)

    skinned, _ = body(radius, [0, 3, 6.5, 9.5])

    def ring(z):
        return lambda t: [
            0.7 * math.cos(2 * math.pi * t),
            math.sqrt(radius(z + 0.7 * math.sin(2 * math.pi * t)) ** 2 - (0.7 * math.cos(2 * math.pi * t)) ** 2),
            z + 0.7 * math.sin(2 * math.pi * t),
        ]

    def handle(z0, z1, reach):
        middle, half = (z0 + z1) / 2, (z0 - z1) / 2
        return lambda t: [0, 4.036 + reach * math.sin(math.pi * t), middle + half * math.cos(math.pi * t)]

    return [
        skinned,
        lid(radius(0), 0),
        sharp("c0"),
        hole(ring(7.7)),
        hole(ring(2.0)),
        glue(handle(8.4, 1.3, 3.6), handle(7.0, 2.7, 2.4)),
    ], (8.2, 11.7, 9.5)


def pot_radius(z):
    return 5.5 + 3.5 * math.sin(math.pi * (z / 12) ** 0.95)


def pot():
    skinned, meridian = body(pot_radius, [0, 3, 6.5, 10, 12])
    return [
        skinned,
        insert(meridian(math.pi / 2)),
        insert(meridian(-math.pi / 2)),
        lid(pot_radius(0), 0),
        sharp("c0"),
    ], (18, 18, 12)


def pot_two_spines():
    skinned, _ = body(pot_radius, [0, 3, 6.5, 10, 12])
    return [skinned, lid(pot_radius(0), 0), sharp("c0")], (18, 18, 12)


def vase():
    def radius(z):
        return 4 + 1.6 * math.sin(0.45 * z + 0.4)

    skinned, _ = body(radius, [0, 4, 8, 12, 16], (0.3, 0.3 + math.pi))
    return [skinned, lid(radius(0), 0, 0.3 + math.pi / 2), sharp("c0")], (11, 11, 16)


def teapot():
    skinned, _ = body(pot_radius, [0, 3, 6.5, 10, 12])
    d = (0, 0.55, -0.835)
    return [
        skinned,
        lid(pot_radius(0), 0),
        lid(pot_radius(12), 12),
        sharp("c0"),
        sharp("c4"),
        hole(on_body(pot_radius, math.pi / 2, 4.75, 0.95, 1.0)),
        insert(circle((0, 15, 11), X, d, 0.75), True),
        glue(
            through([[0, 8.93, 5.75], [0, 10.1, 6.2], [0, 11.4, 7.6], [0, 13.2, 10.1], [0, 14.4, 11.3], [0, 15.0, 11.5]]),
            through([[0, 8.93, 3.75], [0, 10.0, 4.3], [0, 11.1, 5.9], [0, 12.7, 8.8], [0, 13.8, 10.0], [0, 14.5, 10.4]]),
        ),
        hole(on_body(pot_radius, -math.pi / 2, 8.3, 0.7, 0.75)),
        hole(on_body(pot_radius, -math.pi / 2, 4.75, 0.7, 0.7)),
        glue(
            lambda t: [0, -8.93 - 5.3 * math.sin(math.pi * t), 6.5 + 2.55 * math.cos(math.pi * t)],
            lambda t: [0, -8.93 - 4.0 * math.sin(math.pi * t), 6.45 + 1.05 * math.cos(math.pi * t)],
        ),
    ], (18, 29, 12)


def bottle():
    def radius(z):
        s = min(1, max(0, (z - 12) / 7))
        return 3.55 - 2.25 * s * s * (3 - 2 * s)

    heights = [0, 3, 6, 9, 13, 16, 19, 24]
    skinned, meridian = body(radius, heights)
    return [skinned, insert(meridian(math.pi / 2)), insert(meridian(-math.pi / 2)), lid(radius(0), 0), sharp("c0")], (
        7,
        7,
        24,
    )


def hull():
    def half(x):
        s = x / 600
        return 104 * (1 - max(0, s) ** 2.2)

    def sheer(x):
        return 60 + 43 * (x / 600) ** 2

    def keel(x):
        s = max(0, (x - 380) / 220)
        return 103 * s**2.2 if s > 0 else 0

    def chine_half(x):
        return 84 * (1 - (x / 600) ** 2.4)

    def chine(x):
        return 20 + 83 * (x / 600) ** 3

    def outline(t):
        if t < 0.46:
            x = 600 * t / 0.46
            return [x, half(x), sheer(x)]
        if t < 0.92:
            x = 600 * (0.92 - t) / 0.46
            return [x, -half(x), sheer(x)]
        s = (t - 0.92) / 0.08
        return [0, -104 + 208 * s, 60]

    def keel_line(t):
        if t < 0.9:
            x = 600 * (1 - t / 0.9)
            return [x, 0, keel(x)]
        return [0, 0, 60 * (t - 0.9) / 0.1]

    def chine_line(sign):
        def at(t):
            if t < 0.87:
                x = 600 * (1 - t / 0.87)
                return [x, sign * chine_half(x), chine(x)]
            s = (t - 0.87) / 0.13
            return [0, sign * 84 * (1 - s), 20 * (1 - s)]

        return at

    return [
        insert(outline, True, sharpness=1),
        insert(keel_line, sharpness=1),
        insert(chine_line(1), sharpness=1),
        insert(chine_line(-1), sharpness=1),
        insert(line([0, 104, 60], [0, 84, 20]), n=31, sharpness=1),
        insert(line([0, -104, 60], [0, -84, 20]), n=31, sharpness=1),
    ], (600, 208, 103)


def dish():
    def rim(t):
        a = 2 * math.pi * t
        return [15 * math.cos(a), 10 * math.sin(a), 0.4 * math.cos(4 * a)]

    def across(angle):
        c, s = 15 * math.cos(angle), 10 * math.sin(angle)
        z = 0.4 * math.cos(4 * angle)
        return lambda t: [c * (1 - 2 * t), s * (1 - 2 * t), z - 4 * (1 - (1 - 2 * t) ** 2)]

    def ring(t):
        a = 2 * math.pi * t
        return [8 * math.cos(a), 5.3333 * math.sin(a), -2.46222 + 0.1 * (math.cos(4 * a) - 1)]

    return [insert(rim, True), insert(across(0.0)), insert(across(math.pi / 2)), insert(ring, True)], (30, 20, 4.5)


def helmet():
    def rim(t):
        a = 2 * math.pi * t
        return [10 * math.cos(a), 13 * math.sin(a), 0.8 * math.sin(a)]

    def arch(angle):
        c, s = 10 * math.cos(angle), 13 * math.sin(angle)

        def at(t):
            b = math.pi * t
            return [c * math.cos(b), s * math.cos(b), 0.8 * math.sin(angle) * math.cos(b) + 11 * math.sin(b)]

        return at

    def band(y):
        w = 10 * math.sqrt(1 - (y / 13) ** 2)
        h = 11 * math.sqrt(1 - (y / 13) ** 2)

        def at(t):
            b = math.pi * t
            return [w * math.cos(b), y, h * math.sin(b) + 0.8 * y / 13]

        return at

    return [insert(rim, True), insert(arch(math.pi / 2)), insert(band(-6)), insert(band(1)), insert(band(7))], (20, 26, 11)


def tray():
    """A box with round edges, open above: a rim, a bottom ring and four walls."""

    def rounded(w, h, z):
        def at(t):
            a = 2 * math.pi * t
            c, s = math.cos(a), math.sin(a)
            r = (abs(c / w) ** 4 + abs(s / h) ** 4) ** -0.25
            return [r * c, r * s, z]

        return at

    def side(angle):
        p, q = rounded(12, 8, 0)(angle), rounded(10.5, 7, -5)(angle)
        return through([p, [0.55 * p[0] + 0.45 * q[0], 0.55 * p[1] + 0.45 * q[1], -2.5], q])

    return [
        skin([rounded(12, 8, 0), rounded(11.4, 7.6, -2.5), rounded(10.5, 7, -5)], [side(0.0), side(0.5)]),
        sharp("c2"),
        insert(side(0.25)),
        insert(side(0.75)),
        insert(line(rounded(10.5, 7, -5)(0.25), rounded(10.5, 7, -5)(0.75)), n=31),
        insert(line(rounded(10.5, 7, -5)(0.0), rounded(10.5, 7, -5)(0.5)), n=31),
    ], (24, 16, 5)


OBJECTS = {f.__name__: f for f in (saddle, lamp, mug, pot, pot_two_spines, vase, teapot, bottle, hull, dish, helmet, tray)}
# What the exact curves give: faces of the model.
FACES = {
    "saddle": 10,
    "lamp": 4,
    "mug": 17,
    "pot": 18,
    "pot_two_spines": 10,
    "vase": 10,
    "teapot": 26,
    "bottle": 30,
    "hull": 6,
    "dish": 8,
    "helmet": 8,
    "tray": 12,
}


def smooth_noise(n, sigma, rng):
    """Unit variance in all; nine tenths of it smooth over `sigma` samples."""
    reach = int(4 * sigma) + 1
    white = [rng.gauss(0, 1) for _ in range(n + 2 * reach)]
    kernel = [math.exp(-0.5 * (k / sigma) ** 2) for k in range(-reach, reach + 1)]
    norm = math.sqrt(sum(w * w for w in kernel))
    smooth = [sum(kernel[k] * white[i + k] for k in range(2 * reach + 1)) / norm for i in range(n)]
    return [math.sqrt(0.88) * s + math.sqrt(0.12) * rng.gauss(0, 1) for s in smooth]


def draw(one, hand, size):
    curve, closed, n = one["curve"], one["closed"], one["n"]
    points = [curve(k / n if closed else k / (n - 1)) for k in range(n)]
    if hand["tremor"] == 0 and hand["off"] == 0:
        return {"points": points, **({"closed": True} if closed else {})}
    rng, scale = hand["rng"], hand["tremor"] * size / math.sqrt(3)
    noise = [smooth_noise(n, 2.8, rng) for _ in range(3)]
    points = [[points[k][i] + scale * noise[i][k] for i in range(3)] for k in range(n)]
    for end in range(2):
        points.reverse()
        by = rng.gauss(0, hand["off"] * size)
        if by > 0:  # too far, straight on
            step = [points[-1][i] - points[-3][i] for i in range(3)]
            length = math.hypot(*step) or 1.0
            tip = points[-1]
            points += [[tip[i] + by * k / 3 * step[i] / length for i in range(3)] for k in (1, 2, 3)]
        else:
            left = -by
            while len(points) > 12 and left > 0:
                left -= math.dist(points[-1], points[-2])
                points.pop()
    return {"points": [[round(x, 5) for x in p] for p in points], **({"closed": True} if closed else {})}


def session(name, tremor, off, seed):
    edits, extent = OBJECTS[name]()
    size = math.hypot(*extent)
    hand = {"tremor": tremor, "off": off, "rng": random.Random(f"{name} {seed}")}
    lines = [{"batten_session": 1, "unit": "cm"}]
    for edit in edits:
        done = {"op": edit["op"]}
        for key, value in edit.items():
            if key == "stroke":
                done.update(draw(value, hand, size))
            elif key in ("first", "second"):
                done[key] = draw(value, hand, size)
            elif key in ("profiles", "spines"):
                done[key] = [draw(v, hand, size) for v in value]
            else:
                done[key] = value
        lines.append(done)
    return lines


def write(path, lines):
    with open(path, "w") as out:
        out.writelines(json.dumps(one) + "\n" for one in lines)


def judge(batten, name, path, method, levels):
    base = path[: -len(".jsonl")]
    run = subprocess.run(
        [batten, "sketch", path, "-o", base + ".batten", "--surface", base + ".ply", "--method", method, "--levels",
         str(levels), "--threads", "1", "--json"],
        capture_output=True,
        text=True,
    )
    result = {"exit": run.returncode, "why": ""}
    try:
        told = json.loads(run.stdout)
    except ValueError:
        return {**result, "sound": False, "complete": False, "jump": None, "why": run.stderr[-200:]}
    surface = told.get("surface", {})
    result["complete"] = not told.get("refused") and told.get("faces") == FACES[name]
    result["sound"] = (
        run.returncode == 0 and surface.get("crossing_pairs", 1) == 0 and surface.get("turned_triangles", 1) == 0
    )
    smooth = (surface.get("continuity") or {}).get("smooth")
    result["jump"] = smooth["max_normal_jump_deg"] if smooth else None
    refused = "; ".join(f"l{r['line']} {r['op']}: {r['reason']}" for r in told.get("refused", []))
    result["why"] = " | ".join(
        str(w)
        for w in (
            refused,
            f"{told.get('faces')} faces" if told.get("faces") != FACES[name] else "",
            (surface.get("error") or "")[:120],
            f"x{surface.get('crossing_pairs')} t{surface.get('turned_triangles')} {surface.get('broken_faces')}"
            if surface.get("crossing_pairs") or surface.get("turned_triangles")
            else "",
            f"kept {surface.get('not_smoothed')}" if surface.get("not_smoothed") else "",
            f"plates {surface.get('filled_as_plates')}" if surface.get("filled_as_plates") else "",
            f"membranes {surface.get('filled_as_membranes')}" if surface.get("filled_as_membranes") else "",
        )
        if w
    )
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("write", "judge"))
    parser.add_argument("where", help="directory to write to, or the program to judge")
    parser.add_argument("--objects", default=",".join(OBJECTS))
    parser.add_argument("--tremor", type=float, default=0)
    parser.add_argument("--off", type=float, default=0)
    parser.add_argument("--seed", default="1")
    parser.add_argument("--hands", default="1,2")
    parser.add_argument("--method", default="v2")
    parser.add_argument("--levels", type=int, default=2)
    parser.add_argument("--only", default="", help="levels of tremor in per cent, such as 0,0.5")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", default="", help="directory that keeps sessions and results")
    arguments = parser.parse_args()
    objects = arguments.objects.split(",")
    if arguments.what == "write":
        os.makedirs(arguments.where, exist_ok=True)
        for name in objects:
            write(
                os.path.join(arguments.where, name + ".jsonl"),
                session(name, arguments.tremor, arguments.off, arguments.seed),
            )
        return
    levels = [(0, 0), (0.2, 0.3), (0.5, 0.8), (1, 1.2)]
    if arguments.only:
        levels = [one for one in levels if f"{one[0]:g}" in arguments.only.split(",")]
    with tempfile.TemporaryDirectory() as temporary, concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        folder = arguments.keep or temporary
        os.makedirs(folder, exist_ok=True)
        jobs = []
        for tremor, off in levels:
            for hand in arguments.hands.split(",") if tremor else ["0"]:
                for name in objects:
                    path = os.path.join(folder, f"{name}-{tremor:g}-{hand}.jsonl")
                    write(path, session(name, tremor / 100, off / 100, hand))
                    job = pool.submit(judge, arguments.where, name, path, arguments.method, arguments.levels)
                    jobs.append((tremor, hand, name, job))
        counts = {}
        for tremor, hand, name, job in jobs:
            r = job.result()
            good = r["sound"] and r["complete"]
            done, of, sound, complete, smooth = counts.get(tremor, (0, 0, 0, 0, 0))
            is_smooth = r["jump"] is not None and r["jump"] <= 5
            counts[tremor] = (done + good, of + 1, sound + r["sound"], complete + r["complete"], smooth + (good and is_smooth))
            jump = "-" if r["jump"] is None else f"{r['jump']:.1f}"
            print(
                f"{tremor:4g} {hand:>2} {name:15} exit {r['exit']} {'sound' if r['sound'] else '     '} "
                f"{'complete' if r['complete'] else '        '} jump {jump:>6}  {r['why']}",
                flush=True,
            )
        for tremor, (done, of, sound, complete, smooth) in counts.items():
            print(f"tremor {tremor:g} %: {done} of {of} sound and complete ({sound} sound, {complete} complete, {smooth} also smooth)")


if __name__ == "__main__":
    main()
