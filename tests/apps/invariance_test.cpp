#include "apps/run_json.hpp"
#include "sanitizers.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

using Json = nlohmann::json;
using Vector = std::array<double, 3>;

// The same object, told otherwise, must give the same network and surface. The files are changed here, by
// hand, so that readers and writers are part of what is tried.

struct TextCurve {
  bool boundary = false, closed = false;
  std::vector<int> readings, nodes;  ///< as in the file: readings from 1, nodes from 0
  std::vector<std::array<double, 7>> rows;
};

std::vector<TextCurve> read_scan_text(const std::string& name) {
  std::istringstream raw(read_file(name));
  std::stringstream in;
  for (std::string line; std::getline(raw, line);) in << line.substr(0, line.find('#')) << '\n';
  size_t n_curves = 0, n = 0;
  in >> n_curves;
  std::vector<TextCurve> curves(n_curves);
  for (TextCurve& curve : curves) {
    in >> curve.boundary >> curve.closed >> n;
    curve.readings.resize(n), curve.nodes.resize(n);
    for (int& value : curve.readings) in >> value;
    for (int& value : curve.nodes) in >> value;
    in >> n;
    curve.rows.resize(n);
    for (auto& row : curve.rows)
      for (double& value : row) in >> value;
  }
  EXPECT_TRUE(in) << name;
  return curves;
}

void write_scan_text(const std::string& name, const std::vector<TextCurve>& curves) {
  std::ostringstream out;
  out.precision(17);
  out << "# tangents: at-sample\n" << curves.size() << '\n';
  for (const TextCurve& curve : curves) {
    out << curve.boundary << '\n' << curve.closed << '\n' << curve.nodes.size() << '\n';
    for (const int value : curve.readings) out << value << ' ';
    out << '\n';
    for (const int value : curve.nodes) out << value << ' ';
    out << '\n' << curve.rows.size() << '\n';
    for (const auto& row : curve.rows) {
      for (const double value : row) out << value << ' ';
      out << '\n';
    }
  }
  write_file(name, out.str());
}

/// Rotation by 70° about (1, 2, 3), rows; a mirror flips x first.
Vector turned(const Vector& p, bool mirror = false) {
  const double angle = 70 * 3.14159265358979323846 / 180, c = std::cos(angle), s = std::sin(angle);
  const double length = std::sqrt(14.0);
  const Vector u{1 / length, 2 / length, 3 / length}, q{mirror ? -p[0] : p[0], p[1], p[2]};
  const double along = u[0] * q[0] + u[1] * q[1] + u[2] * q[2];
  const Vector cross{u[1] * q[2] - u[2] * q[1], u[2] * q[0] - u[0] * q[2], u[0] * q[1] - u[1] * q[0]};
  Vector r;
  for (int k = 0; k < 3; ++k) r[k] = c * q[k] + s * cross[k] + (1 - c) * along * u[k];
  return r;
}

/// The network of a scan file, as JSON with "positions" and "curves".
Json network_of(const std::string& scan) {
  run_json("network " + scan + " -o of_scan.json --step 4%");
  return Json::parse(read_file("of_scan.json"));
}

std::vector<Vector> curve_points(const Json& network, size_t curve) {
  std::vector<Vector> points;
  for (const int v : network["curves"][curve]["vertices"])
    points.push_back(network["positions"][static_cast<size_t>(v)].get<Vector>());
  return points;
}

double largest_difference(const std::vector<Vector>& a, const std::vector<Vector>& b) {
  if (a.size() != b.size()) return INFINITY;
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i)
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::abs(a[i][k] - b[i][k]));
  return largest;
}

class InvarianceOfScans : public ::testing::Test {
 protected:
  void SetUp() override {
    run_json(
        "simulate ellipsoid -o scan.rawnet --step 1.5% --seed 41 --orientation-noise 2deg --drift 1deg "
        "--odometer-error 0.3%");
    scan_ = read_scan_text("scan.rawnet");
    network_ = network_of("scan.rawnet");
    size_ = 3.9;  // of the ellipsoid with half-axes 1.5, 1, 0.7: its diameter
  }
  std::vector<TextCurve> scan_;
  Json network_;
  double size_ = 0;
};

TEST_F(InvarianceOfScans, OrderOfCurvesAndUnitOfLengthDoNotMatter) {
  std::vector<TextCurve> changed = scan_;
  std::reverse(changed.begin(), changed.end());
  write_scan_text("permuted.rawnet", changed);
  const Json permuted = network_of("permuted.rawnet");
  for (size_t c = 0; c < scan_.size(); ++c)
    EXPECT_LT(largest_difference(curve_points(permuted, scan_.size() - 1 - c), curve_points(network_, c)),
              1e-8 * size_);
  for (const double scale : {1e-3, 1e3}) {
    changed = scan_;
    for (TextCurve& curve : changed)
      for (auto& row : curve.rows) row[0] *= scale;
    write_scan_text("scaled.rawnet", changed);
    const Json scaled = network_of("scaled.rawnet");
    for (size_t c = 0; c < scan_.size(); ++c) {
      std::vector<Vector> points = curve_points(scaled, c);
      for (Vector& p : points)
        for (double& x : p) x /= scale;
      EXPECT_LT(largest_difference(points, curve_points(network_, c)), 1e-8 * size_) << scale;
    }
  }
}

TEST_F(InvarianceOfScans, RotationMirrorAndDirectionOfCurvesDoNotMatter) {
  for (const bool mirror : {false, true}) {
    std::vector<TextCurve> changed = scan_;
    for (TextCurve& curve : changed)
      for (auto& row : curve.rows)
        for (const int first : {1, 4}) {
          const Vector direction = turned({row[first], row[first + 1], row[first + 2]}, mirror);
          std::copy(direction.begin(), direction.end(), row.begin() + first);
        }
    write_scan_text("turned.rawnet", changed);
    const Json result = network_of("turned.rawnet");
    for (size_t c = 0; c < scan_.size(); ++c) {
      std::vector<Vector> expected = curve_points(network_, c);
      for (Vector& p : expected) p = turned(p, mirror);
      EXPECT_LT(largest_difference(curve_points(result, c), expected), 1e-8 * size_) << mirror;
    }
  }
  std::vector<TextCurve> changed = scan_;
  for (TextCurve& curve : changed) {
    const double end = curve.rows.back()[0];
    const int n = static_cast<int>(curve.rows.size());
    std::reverse(curve.rows.begin(), curve.rows.end());
    for (auto& row : curve.rows) {
      row[0] = end - row[0];
      for (int k = 1; k < 4; ++k) row[k] = -row[k];
    }
    std::reverse(curve.nodes.begin(), curve.nodes.end());
    std::reverse(curve.readings.begin(), curve.readings.end());
    for (int& reading : curve.readings) reading = n + 1 - reading;
  }
  write_scan_text("reversed.rawnet", changed);
  const Json reversed = network_of("reversed.rawnet");
  for (size_t c = 0; c < scan_.size(); ++c) {
    std::vector<Vector> points = curve_points(reversed, c);
    std::reverse(points.begin(), points.end());
    EXPECT_LT(largest_difference(points, curve_points(network_, c)), 1e-8 * size_);
  }
}

/// Largest distance of the surface of one network from that of another, over the diameter of the latter.
double surface_difference(const Json& network, const std::string& reference) {
  write_file("told_otherwise.json", network.dump());
  run_json("surface told_otherwise.json -o otherwise.ply");
  const Json compared = run_json("compare otherwise.ply " + reference + " --samples 5000");
  return std::max(compared["relative"]["a_to_b"]["max"].get<double>(),
                  compared["relative"]["b_to_a"]["max"].get<double>());
}

TEST(InvarianceOfSurfaces, TellingTheNetworkOtherwiseGivesTheSameSurface) {
  // Closed, and open with a border; without the symmetry that would hide a mistake.
  for (const char* shape : {"ellipsoid", "dish"}) {
    if (test::kSanitized && shape == std::string("ellipsoid")) continue;
    SCOPED_TRACE(shape);
    run_json(std::string("simulate ") + shape +
             " -o x.rawnet --step 4% --truth-network fine.json --truth-step 0.5%");
    run_json("convert fine.json exact.json --resample 4%");
    run_json("surface exact.json -o exact.ply");
    const Json exact = Json::parse(read_file("exact.json"));

    Json changed = exact;
    std::reverse(changed["curves"].begin(), changed["curves"].end());
    EXPECT_LT(surface_difference(changed, "exact.ply"), 1e-8) << "order of curves";

    // The reference is moved with the network: as a mesh in OFF, whose text is easily changed.
    run_json("surface exact.json -o exact.off");
    const auto moved_reference = [](double scale, const Vector& shift, bool turn, bool mirror) {
      std::istringstream in(read_file("exact.off"));
      std::ostringstream out;
      out.precision(17);
      std::string line;
      std::vector<std::string> lines;
      while (std::getline(in, line))
        if (!line.empty() && line[0] != '#') lines.push_back(line);
      size_t n_vertices = 0;
      lines[0] = "OFF";  // the normals that follow the coordinates are dropped
      std::istringstream(lines[1]) >> n_vertices;
      for (size_t i = 0; i < lines.size(); ++i) {
        if (i < 2 || i >= 2 + n_vertices) {
          out << lines[i] << '\n';
          continue;
        }
        Vector p;
        std::istringstream(lines[i]) >> p[0] >> p[1] >> p[2];
        if (turn) p = turned(p, mirror);
        for (int k = 0; k < 3; ++k) out << scale * p[k] + shift[k] << (k < 2 ? ' ' : '\n');
      }
      write_file("moved.off", out.str());
    };
    const auto moved_network = [&exact](double scale, const Vector& shift, bool turn, bool mirror) {
      Json network = exact;
      for (auto& position : network["positions"]) {
        Vector p = position.get<Vector>();
        if (turn) p = turned(p, mirror);
        for (int k = 0; k < 3; ++k) p[k] = scale * p[k] + shift[k];
        position = p;
      }
      if (turn)
        for (auto& normal : network["normals"]) normal = turned(normal.get<Vector>(), mirror);
      return network;
    };
    // Exact ties of a symmetric shape may break the other way, always so in a mirror: other triangles, whose
    // difference falls with the square of the step. 0.03 % of the diameter at 2 % are 0.12 % at the 4 % of
    // this test.
    struct Motion {
      const char* name;
      double scale;
      Vector shift;
      bool turn, mirror;
      double limit;
    };
    for (const Motion& m : {Motion{"translation", 1, {5, -3, 2}, false, false, 1e-8},
                            Motion{"scale 1e-3", 1e-3, {0, 0, 0}, false, false, 1e-8},
                            Motion{"scale 1e3", 1e3, {0, 0, 0}, false, false, 1e-8},
                            Motion{"rotation", 1, {0, 0, 0}, true, false, 1.2e-3},
                            Motion{"mirror", 1, {0, 0, 0}, true, true, 1.2e-3}}) {
      moved_reference(m.scale, m.shift, m.turn, m.mirror);
      const double difference =
          surface_difference(moved_network(m.scale, m.shift, m.turn, m.mirror), "moved.off");
      EXPECT_LT(difference, m.limit) << m.name;
      RecordProperty(std::string(shape) + " " + m.name, std::to_string(difference));
    }
    changed = exact;
    for (auto& curve : changed["curves"]) std::reverse(curve["vertices"].begin(), curve["vertices"].end());
    EXPECT_LT(surface_difference(changed, "exact.ply"), 1.2e-3) << "direction of curves";
  }
}

}  // namespace
}  // namespace batten::test
