#pragma once

namespace batten::linalg_detail {

/// While one lives, OpenBLAS works on one thread, and parallel regions of OpenMP that the calling thread
/// enters run on it alone; both settings are as they were before when the last has gone.
///
/// Sums of OpenBLAS depend on its number of threads, and ours must not. CHOLMOD's supernodal code asks OpenMP
/// for four threads, however many processors there are, and lets them meet several times per supernode: on
/// two busy processors that took 81 s instead of 4.6 s for a surface of 100,000 vertices.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int levels_ = -1;  ///< of OpenMP's active parallel regions, before; −1 without OpenMP
};

}  // namespace batten::linalg_detail
