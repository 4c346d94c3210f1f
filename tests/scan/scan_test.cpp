#include "batten/scan/scan.hpp"

#include "scan/scan_fixtures.hpp"

#include <functional>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

/// Expects InvalidInput with both words in its sentence.
void expect_refused(const std::function<void(Scan&)>& spoil, const std::string& place,
                    const std::string& what) {
  SimulateOptions options;
  options.step = 0.02;
  Scan scan = simulate_scan(trace_shape(AnalyticShape::Sphere), options).scan;
  ASSERT_NO_THROW(check_scan(scan));
  spoil(scan);
  try {
    check_scan(scan);
    FAIL() << "accepted: " << what;
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

TEST(CheckScan, NamesCurveReadingAndFault) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect_refused([](Scan& s) { s.curves.clear(); }, "scan", "no curves");
  expect_refused([&](Scan& s) { s.curves[1].distances[4] = nan; }, "curve 2", "not a finite");
  expect_refused([](Scan& s) { s.curves[0].tangents.row(6).setZero(); }, "reading 7", "tangent is zero");
  expect_refused([](Scan& s) { s.curves[0].normals.row(6).setZero(); }, "reading 7", "normal is zero");
  expect_refused([](Scan& s) { s.curves[2].tangents.row(2) = s.curves[2].normals.row(2); }, "curve 3",
                 "parallel");
  expect_refused([](Scan& s) { s.curves[0].distances[9] = 0; }, "reading 10", "decreases");
  expect_refused([](Scan& s) { s.curves[0].distances.conservativeResize(1); }, "curve 1", "at least two");
  expect_refused([](Scan& s) { s.curves[0].node_readings[1] = 100000; }, "curve 1", "node");
  expect_refused([](Scan& s) { s.curves[0].node_ids.back() += 1; }, "curve 1", "closed");
  expect_refused(
      [](Scan& s) {
        for (int& id : s.curves[2].node_ids) id += 100;
      },
      "curve 3", "not connected");
}

}  // namespace
}  // namespace batten
