#pragma once
#include "batten/camera/rig.hpp"
#include "batten/core/units.hpp"
#include "batten/rotation/so3.hpp"

namespace batten::test {

/// Of the kind that a webcam has: barrel distortion, corners at a radius of 0.75.
inline Camera webcam() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 535;
  camera.fy = 534;
  camera.cx = 331;
  camera.cy = 243;
  camera.k1 = -0.27;
  camera.k2 = 0.045;
  camera.k3 = 0.037;
  camera.p1 = 0.0024;
  camera.p2 = -0.0011;
  return camera;
}

/// Two webcams 0.25 m apart that converge by 8 degrees.
inline StereoRig webcam_rig() {
  StereoRig rig;
  rig.left = webcam();
  rig.right = webcam();
  rig.right.fx = 540;
  rig.right.cx = 322;
  rig.rotation = so3_exp(Eigen::Vector3d(0.01, -radians(8.0), 0.02));
  rig.translation = -(rig.rotation * Eigen::Vector3d(0.25, 0.003, -0.002));
  return rig;
}

}  // namespace batten::test
