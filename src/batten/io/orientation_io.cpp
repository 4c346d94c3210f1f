#include "batten/io/orientation_io.hpp"

#include <cmath>
#include <cstddef>
#include <cstdio>

#include "batten/core/text.hpp"
#include "batten/core/units.hpp"
#include "batten/io/file.hpp"

namespace batten {

namespace {

/// Nine digits of a quaternion are 1e-7 degrees; a standard deviation has no use for more than four.
void append(std::string& text, const char* form, double value) {
  text += ',';
  if (std::isnan(value)) return;
  char digits[32];
  std::snprintf(digits, sizeof digits, form, value);
  text += digits;
}

}  // namespace

void write_orientations(const OrientationEstimate& estimate, const Eigen::VectorXd& time,
                        const std::string& path) {
  std::string text = "time_s,w,x,y,z,tilt_sd_deg,heading_sd_deg\n";
  OutputFile out(path);
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    text += exact_decimal(time[i]);
    for (int k = 0; k < 4; ++k) append(text, "%.9f", estimate.quaternions(i, k));
    append(text, "%.4g", degrees(estimate.tilt_deviation[i]));
    append(text, "%.4g", degrees(estimate.heading_deviation[i]));
    text += '\n';
    if (text.size() > std::size_t{1} << 20) {
      out.write(text);
      text.clear();
    }
  }
  out.write(text);
  out.commit();
}

}  // namespace batten
