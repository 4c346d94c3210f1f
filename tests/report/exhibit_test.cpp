#include "batten/report/exhibit.hpp"

#include "mesh/shapes.hpp"
#include "network/sample_networks.hpp"

#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten {
namespace {

TriangleMesh sphere() {
  return fixtures::as_mesh(fixtures::sphere(4));
}

std::string titles(const std::vector<ReportPicture>& pictures) {
  std::string list;
  for (const ReportPicture& picture : pictures) list += picture.title + ";";
  return list;
}

TEST(ExhibitPictures, ShowWhatFits) {
  EXPECT_TRUE(exhibit_pictures({}).empty());
  Exhibit exhibit;
  exhibit.mesh.emplace();  // no triangle: nothing to draw
  EXPECT_TRUE(exhibit_pictures(exhibit).empty());
  exhibit.mesh = sphere();
  const std::vector<ReportPicture> mesh = exhibit_pictures(exhibit);
  EXPECT_EQ(titles(mesh),
            "The surface;Isophotes;Reflection lines;Normal map;Mean curvature;Gaussian curvature;Wireframe;");
  for (const ReportPicture& picture : mesh) {
    EXPECT_EQ(picture.png.substr(0, 8), "\x89PNG\r\n\x1a\n") << picture.title;  // ISO 15948, 5.2
    EXPECT_EQ(picture.wide, picture.title == "The surface");
  }
}

TEST(ExhibitPictures, ShowErrorsAndTheNetwork) {
  Exhibit exhibit;
  exhibit.network = samples::octahedral_sphere(4);
  EXPECT_EQ(titles(exhibit_pictures(exhibit)), "The network;Porcupine plot;Gauss map;");
  exhibit.network = samples::without_normals(*exhibit.network);
  exhibit.errors = Eigen::VectorXd::LinSpaced(exhibit.network->positions.rows(), 0, 1);
  const std::vector<ReportPicture> pictures = exhibit_pictures(exhibit);
  EXPECT_EQ(titles(pictures), "The network;Distance to the truth;");
  EXPECT_NE(pictures[0].png, pictures[1].png);
  exhibit.errors.conservativeResize(3);
  EXPECT_THROW(exhibit_pictures(exhibit), InvalidInput);
}

TEST(ExhibitPictures, AreCancelled) {
  Exhibit exhibit;
  exhibit.mesh = sphere();
  EXPECT_THROW(exhibit_pictures(exhibit, Progress([](std::string_view, double) { return false; })),
               Cancelled);
}

}  // namespace
}  // namespace batten
