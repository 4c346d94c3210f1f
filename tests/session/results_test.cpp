#include "../sketch/strokes.hpp"
#include "one_model.hpp"

#include <map>

#include <gtest/gtest.h>

#include "batten/fairing/fair.hpp"
#include "batten/modelling/model_surface.hpp"
#include "batten/session/journal.hpp"

// A caller that makes and keeps the results of a project, as a studio does: the document tells what is out of
// date, and its requests are all that is needed.
namespace batten {
namespace {

using namespace strokes;
using namespace test;

class Results {
 public:
  int update(const Document& document) {
    int n = 0;
    for (const ObjectId id : document.out_of_date(versions_)) {
      const Derived& derived = *document.object(id).derived();
      if (const auto* surface = std::get_if<ModelSurfaceRequest>(&*derived.request)) {
        meshes_[id] = model_surface(document.model(derived.source), surface->options).mesh;
      } else {
        const auto& options = std::get<FairRequest>(*derived.request).options;
        TriangleMesh mesh = meshes_.at(derived.source);
        mesh.positions = fair(mesh.positions, mesh.triangles, options).positions;
        meshes_[id] = mesh;
      }
      versions_[id] = document.version(id);
      ++n;
    }
    return n;
  }
  const TriangleMesh& mesh(ObjectId id) const { return meshes_.at(id); }

 private:
  std::map<ObjectId, std::uint64_t> versions_;
  std::map<ObjectId, TriangleMesh> meshes_;
};

TEST(Results, AreMadeFromRequestsWhereTheyAreOutOfDate) {
  Document document = one_model();
  for (const auto& stroke : {circle(kO, kX, kY), circle(kO, kX, kZ), circle(kO, kY, kZ)})
    document.apply(on_model(InsertEdit{stroke, {}}));
  ModelSurfaceRequest coons;
  coons.options.method = ModelSurfaceMethod::Coons;
  coons.options.levels = 1;
  const ObjectId surface = document.apply(DeriveEdit{{}, "surface", kModel, coons}).object;
  FairRequest taubin;
  taubin.options.method = FairingMethod::Taubin;
  taubin.options.iterations = 2;
  const ObjectId smooth = document.apply(DeriveEdit{{}, "smooth", surface, taubin}).object;
  Results kept;
  EXPECT_EQ(kept.update(document), 2);
  const TriangleMesh first = kept.mesh(smooth);
  document.apply(RenameEdit{surface, "sphere"});
  EXPECT_EQ(kept.update(document), 0);
  taubin.options.iterations = 3;
  document.apply(RequestEdit{smooth, taubin, 0});
  EXPECT_EQ(kept.update(document), 1);
  EXPECT_FALSE(kept.mesh(smooth).positions == first.positions);
  document.apply(on_model(TransformEdit{Eigen::Vector4d(2, 1, 1, 1).asDiagonal().toDenseMatrix()}));
  EXPECT_EQ(kept.update(document), 2);
  // What was kept along the way is what a fresh start from the journal makes, bit for bit.
  Document again;
  for (const SessionEdit& edit : parse_session(format_session(document.log()), "journal").edits)
    again.apply(edit.edit);
  Results fresh;
  EXPECT_EQ(fresh.update(again), 2);
  EXPECT_EQ(fresh.mesh(smooth).triangles, kept.mesh(smooth).triangles);
  EXPECT_TRUE(fresh.mesh(smooth).positions == kept.mesh(smooth).positions);
}

}  // namespace
}  // namespace batten
