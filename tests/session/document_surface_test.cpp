#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <iostream>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "batten/core/random.hpp"
#include "batten/modelling/diffusion_surface.hpp"
#include "batten/session/document.hpp"

namespace batten {
namespace {

using namespace strokes;
using namespace test;
using Eigen::Vector3d;

constexpr int kCells = 5;

DrawnStroke on_waves(const Vector3d& from, const Vector3d& to) {
  DrawnStroke stroke{polygon({from, to}, 100), false};
  for (Eigen::Index i = 0; i < stroke.points.rows(); ++i)
    stroke.points(i, 2) = 0.1 * std::sin(2.5 * stroke.points(i, 0)) * std::cos(2 * stroke.points(i, 1));
  return stroke;
}

/// A waved sheet of kCells × kCells faces.
Document sheet() {
  Document document = one_model();
  DrawnStroke border{polygon({kO, kX, kX + kY, kY, kO}, 100), true};
  for (Eigen::Index i = 0; i < border.points.rows(); ++i)
    border.points(i, 2) = 0.1 * std::sin(2.5 * border.points(i, 0)) * std::cos(2 * border.points(i, 1));
  document.apply(on_model(InsertEdit{border, {.snap = 1e-3}}));
  for (int k = 1; k < kCells; ++k) {
    const double t = static_cast<double>(k) / kCells;
    document.apply(on_model(InsertEdit{on_waves(t * kY, kX + t * kY), {.snap = 1e-3}}));
    document.apply(on_model(InsertEdit{on_waves(t * kX, kY + t * kX), {.snap = 1e-3}}));
  }
  return document;
}

/// One of: a curve over some cells, a deletion, a sharpness, undo, redo. Some are refused.
Edit random_surface_edit(const Document& document, Random& random) {
  const double kind = random.uniform();
  const auto curve = [&] {
    return static_cast<int>(random.below(static_cast<std::uint64_t>(model_of(document).n_curves())));
  };
  if (kind < 0.35) {
    const auto cell = [&](int most) {
      return static_cast<int>(random.below(static_cast<std::uint64_t>(most)));
    };
    const int x = cell(kCells - 1);
    const double y = (cell(kCells) + random.uniform(0.3, 0.7)) / kCells;
    const Vector3d from(static_cast<double>(x) / kCells, y, 0), to((x + 1.0 + cell(2)) / kCells, y, 0);
    return on_model(InsertEdit{on_waves(from, to), {.snap = 1e-3}});
  }
  if (kind < 0.45) return on_model(DeleteEdit{curve()});
  if (kind < 0.55) return on_model(SharpnessEdit{curve(), random.uniform() < 0.5 ? 1.0 : 0.0, {}});
  if (kind < 0.8) return UndoEdit{};
  return RedoEdit{};
}

/// Largest distance of vertices of the surface and of its cage, ÷ the diameter.
double difference(const DiffusionSurface& one, const DiffusionSurface& other, const PolylineMesh& mesh) {
  EXPECT_EQ(one.refined.mesh.corners, other.refined.mesh.corners);
  EXPECT_EQ(one.refined.mesh.positions.rows(), other.refined.mesh.positions.rows());
  if (one.refined.mesh.positions.rows() != other.refined.mesh.positions.rows()) return 1;
  return std::max((one.refined.mesh.positions - other.refined.mesh.positions).rowwise().norm().maxCoeff(),
                  (one.cage.mesh.positions - other.cage.mesh.positions).rowwise().norm().maxCoeff()) /
         mesh.diameter();
}

constexpr DiffusionOptions kCoarse{.splits = 2};

// The tolerance is the stated one, five times that of the flow. The surface is asked for after some of the
// edits only, so that updates follow several of them, forth and back.
TEST(DocumentSurface, FollowsRandomEditsUndoAndRedo) {
  double worst = 0;
  int n_compared = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Random random(seed);
    Document document = sheet();
    EditedSurface surface(kCoarse);
    std::vector<size_t> asked_at;  // entries of the log
    DiffusionSurface last;
    for (int k = 0; k < 30; ++k) {
      try {
        document.apply(random_surface_edit(document, random));
      } catch (const RefusedEdit&) {
        continue;
      }
      if (random.uniform() < 0.5) continue;
      surface.update(model_of(document));
      last = surface.surface(model_of(document));
      asked_at.push_back(document.log().size());
      const double found =
          difference(last, diffusion_surface(model_of(document), kCoarse), model_of(document));
      EXPECT_LT(found, 5e-4) << "seed " << seed << ", edit " << k;
      worst = std::max(worst, found);
      ++n_compared;
    }
    // Played again, asked for at the same places: the same bits.
    ASSERT_FALSE(asked_at.empty());
    Document again;
    EditedSurface again_surface(kCoarse);
    DiffusionSurface replayed;
    size_t next = 0;
    for (size_t k = 0; k < asked_at.back(); ++k) {
      again.apply(document.log()[k]);
      if (again.log().size() == asked_at[next]) {
        again_surface.update(model_of(again));
        replayed = again_surface.surface(model_of(again));
        ++next;
      }
    }
    EXPECT_EQ(replayed.refined.mesh.corners, last.refined.mesh.corners) << seed;
    EXPECT_TRUE(replayed.refined.mesh.positions == last.refined.mesh.positions) << seed;
    EXPECT_TRUE(replayed.cage.mesh.positions == last.cage.mesh.positions) << seed;
  }
  EXPECT_GT(n_compared, 15);
  std::cout << n_compared << " surfaces, largest difference " << worst << '\n';
}

TEST(DocumentSurface, IsRedoneOnlyWhereEditsWere) {
  Document document = sheet();
  EditedSurface surface(kCoarse);
  EXPECT_EQ(surface.update(model_of(document)).faces.size(), 25u);
  EXPECT_EQ(surface.update(model_of(document)).faces.size(), 0u);
  const double y = 2.5 / kCells;
  document.apply(on_model(InsertEdit{on_waves(Vector3d(0.4, y, 0), Vector3d(0.6, y, 0)), {.snap = 1e-3}}));
  const size_t made = surface.update(model_of(document)).faces.size();
  EXPECT_GT(made, 1u);
  EXPECT_LT(made, 26u);
  // The surface follows a copy as well, and the copy leaves the document alone.
  Document copy = document;
  EXPECT_EQ(surface.update(model_of(copy)).faces.size(), 0u);
  copy.apply(UndoEdit{});
  surface.update(model_of(copy));
  EXPECT_EQ(surface.surface(model_of(copy)).refined.mesh.n_faces(), 25 * 16);
  EXPECT_EQ(model_of(document).counts().faces, 26);
}

TEST(DocumentSurface, GoesOnAfterWhatFailed) {
  EditedSurface surface(kCoarse);
  EXPECT_THROW(surface.update(model_of(one_model())), InvalidInput);  // no faces yet
  const Document document = sheet();
  EXPECT_THROW(surface.update(model_of(document), Progress([](std::string_view, double) { return false; })),
               Cancelled);
  surface.update(model_of(document));
  EXPECT_LT(difference(surface.surface(model_of(document)), diffusion_surface(model_of(document), kCoarse),
                       model_of(document)),
            5e-4);
}

}  // namespace
}  // namespace batten
