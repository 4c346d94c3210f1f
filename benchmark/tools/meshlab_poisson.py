"""Screened Poisson reconstruction by MeshLab's server, which needs a display even to read files.

usage: meshlab_poisson.py POINTS.ply OUTPUT.ply
"""

import pathlib
import subprocess
import sys

# All parameters: the server of the distribution ends on a script that leaves one out.
SCRIPT = """<!DOCTYPE FilterScript>
<FilterScript>
 <filter name="Surface Reconstruction: Screened Poisson">
  <Param type="RichBool" name="visibleLayer" value="false"/>
  <Param type="RichInt" name="depth" value="8"/>
  <Param type="RichInt" name="fullDepth" value="5"/>
  <Param type="RichInt" name="cgDepth" value="0"/>
  <Param type="RichFloat" name="scale" value="1.1"/>
  <Param type="RichFloat" name="samplesPerNode" value="1.5"/>
  <Param type="RichFloat" name="pointWeight" value="4"/>
  <Param type="RichInt" name="iters" value="8"/>
  <Param type="RichBool" name="confidence" value="false"/>
  <Param type="RichBool" name="preClean" value="false"/>
 </filter>
</FilterScript>
"""


def main():
    points, output = sys.argv[1:]
    pathlib.Path("poisson.mlx").write_text(SCRIPT, encoding="ascii")
    words = ["xvfb-run", "-a", "meshlabserver", "-i", points, "-o", output, "-s", "poisson.mlx"]
    sys.exit(subprocess.run(words, check=False).returncode)


if __name__ == "__main__":
    main()
