#include "batten/session/edit_json.hpp"

#include "../sketch/strokes.hpp"
#include "one_model.hpp"
#include "random_project.hpp"

#include <limits>
#include <set>

#include <gtest/gtest.h>

#include "batten/session/project.hpp"

namespace batten {
namespace {

using namespace strokes;
using namespace test;

std::vector<Edit> one_of_each() {
  const Points square = polygon({kO, kX, kX + kY, kY, kO}, 1);
  MirrorEdit mirror;
  mirror.curve = 4;
  mirror.axis = polygon({kO, kX}, 1);
  MirrorEdit drawn_mirror;
  drawn_mirror.stroke.points = square;
  return {
      on_model(InsertEdit{{square, true}, {.snap = 0.1, .sharpness = 0.25, .into = Into::Opening}}),
      on_model(DeleteEdit{3}),
      on_model(SharpnessEdit{2, 1.0 / 3, std::array<int, 2>{4, 5}}),
      on_model(mirror),
      on_model(drawn_mirror),
      on_model(HoleEdit{{square, false}, {}}),
      on_model(GlueEdit{{square, false}, {square, false}, std::array<int, 2>{4, 7}, {}}),
      on_model(SkinEdit{
          {{square, false}, {square, true}}, {DrawnStroke{square, false}, DrawnStroke{square, false}}, {}}),
      on_model(AlignEdit{2, {square, false}}),
      on_model(TransformEdit{Eigen::Matrix4d::Constant(0.1)}),
      DeriveEdit{{7}, "fair", {3}, FairRequest{}},
      RemoveEdit{{7}, true},
      RenameEdit{{2}, "κ \"new\"\n"},
      UnitEdit{{2}, "mm"},
      UndoEdit{},
      RedoEdit{},
      CheckpointEdit{}};
}

TEST(EditJson, EveryEditReadsBackAsItWasWritten) {
  for (const Edit& edit : one_of_each()) {
    const std::string line = format_edit(edit);
    EXPECT_EQ(line.find('\n'), std::string::npos);
    EXPECT_EQ(format_edit(parse_edit(line)), line);
  }
  const auto sharpness = std::get<SharpnessEdit>(
      std::get<ModelEdit>(
          parse_edit(format_edit(on_model(SharpnessEdit{2, 1.0 / 3, std::array<int, 2>{4, 5}}))))
          .edit);
  EXPECT_EQ(sharpness.value, 1.0 / 3);  // bit for bit
}

TEST(EditJson, EveryContentAndRequestReadsBackAsItWasWritten) {
  RandomProject project(11);
  std::set<std::size_t> contents, requests;
  for (int k = 0; k < 200; ++k) {
    const AddEdit add{{k + 1}, "x", "mm", project.content()};
    const Edit read = parse_edit(format_edit(add));
    EXPECT_TRUE(same_content(std::get<AddEdit>(read).content, add.content)) << format_edit(add);
    contents.insert(add.content.index());
    const RequestEdit request{{k + 1}, project.random_request(), 0};
    const Edit again = parse_edit(format_edit(request));
    EXPECT_TRUE(same_request(std::get<RequestEdit>(again).request, request.request)) << format_edit(request);
    requests.insert(request.request.index());
  }
  EXPECT_EQ(contents.size(), std::variant_size_v<Content>);
  EXPECT_EQ(requests.size(), std::variant_size_v<Request>);
}

// What JSON has no numbers for, and what integers cannot tell, is kept to the bit, in a line and in a
// project.
TEST(EditJson, NumbersOfEveryKindReadBack) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  TriangleMesh mesh;
  mesh.positions = Points::Zero(100, 3);
  mesh.triangles = Triangles(0, 3);
  mesh.vertex_values["odd"] = Eigen::VectorXd::Zero(100);
  mesh.vertex_values["odd"].head(5) << kInfinity, -kInfinity, -0.0, 0.1, 1e300;
  mesh.vertex_values["minus zero"] = Eigen::VectorXd::Constant(100, -0.0);
  mesh.vertex_values["large"] = Eigen::VectorXd::Constant(100, 3e9);
  mesh.vertex_values["least"] = Eigen::VectorXd::Constant(100, -2147483648.0);
  mesh.vertex_values["huge"] = Eigen::VectorXd::Constant(100, 9007199254740993.0);
  const AddEdit add{{1}, "mesh", "m", std::make_shared<const TriangleMesh>(mesh)};
  EXPECT_TRUE(same_content(std::get<AddEdit>(parse_edit(format_edit(add))).content, add.content));
  Document document;
  document.apply(add);
  const ProjectFile read = parse_project(format_project(document), "p.batten");
  EXPECT_TRUE(same_content(*read.document.object({1}).content(), add.content));
}

TEST(EditJson, OptionsThatAreNotWrittenHaveTheirDefaults) {
  const Edit edit = parse_edit(R"({"op":"request","object":"o2","request":{"kind":"network","sigma":0.5}})");
  const auto& options = std::get<NetworkRequest>(std::get<RequestEdit>(edit).request).options;
  EXPECT_EQ(options.sigma, 0.5);
  EXPECT_EQ(options.xi, ScanOptions().xi);
  EXPECT_EQ(options.step->value, ScanOptions().step->value);
}

TEST(EditJson, LinesOfFormat1AreOfTheOneModel) {
  const Edit edit = parse_edit_of_format_1(R"({"op":"delete","curve":"c3"})");
  EXPECT_EQ(std::get<ModelEdit>(edit).object, ObjectId{1});
  EXPECT_EQ(std::get<DeleteEdit>(std::get<ModelEdit>(edit).edit).curve, 3);
  EXPECT_THROW(parse_edit_of_format_1(R"({"op":"delete","object":"o1","curve":"c3"})"), InvalidInput);
  EXPECT_THROW(parse_edit_of_format_1(R"({"op":"rename","object":"o1","name":"x"})"), InvalidInput);
}

TEST(EditJson, MistakesAreNamed) {
  const auto message = [](const std::string& line) -> std::string {
    try {
      parse_edit(line);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& line, const std::string& part) {
    EXPECT_NE(message(line).find(part), std::string::npos) << line << ": " << message(line);
  };
  expect("{}", "no \"op\"");
  expect("[1]", "not a JSON object");
  expect("{\"op\":", "not JSON");
  expect(R"({"op":"cut"})", "no op \"cut\"; the ops are insert");
  expect(R"({"op":"insert"})", "needs the field \"points\"");
  expect(R"({"op":"insert","points":[[0,0]]})", "point 0 is [0,0]");
  expect(R"({"op":"insert","points":[[0,0,NaN]]})", "NaN");
  expect(R"({"op":"insert","points":[[0,0,1e999]]})", "finite");
  expect(R"({"op":"insert","points":[],"snpa":1})", "no field \"snpa\"; it takes op, object, points, closed");
  expect(R"({"op":"insert","points":[],"into":"side"})", "\"auto\", \"face\" or \"opening\"");
  expect(R"({"op":"delete","curve":3})", "the id of a curve");
  expect(R"({"op":"delete","curve":"v3"})", "the id of a curve");
  expect(R"({"op":"transform","matrix":[1,2,3]})", "16 numbers");
  expect(R"({"op":"skin","profiles":[],"spines":[]})", "two objects");
  expect(R"({"op":"insert","points":[]})", "needs the field \"object\"");
  expect(R"({"op":"rename","object":3,"name":"x"})", "the id of an object");
  expect(R"({"op":"insert","object":"o1","points":[[0,0,0],5]})", "point 1 is 5");
  expect(R"({"op":"rename","object":"o2147483647","name":"x"})", "the id of an object");
  EXPECT_EQ(message(R"({"op":"rename","object":"o2147483646","name":"x"})"), "accepted");
  expect(R"({"op":"rename","object":"o3"})", "needs the field \"name\"");
  expect(R"({"op":"undo","object":"o3"})", "no field \"object\"");
  expect(R"({"op":"add","object":"o1","kind":"cloud","name":"x","unit":"","content":{}})",
         "no kind of object");
  expect(R"({"op":"request","object":"o1","request":{"kind":"fair","metod":"tv"}})", "no field \"metod\"");
  expect(R"({"op":"request","object":"o1","request":{"kind":"fair","method":"best"}})", "one of \"auto\"");
  expect(R"({"op":"request","object":"o1","request":{"kind":"fair","iterations":1.5}})", "a whole number");
  expect(
      R"({"op":"request","object":"o1","request":{"kind":"surface","surface":{"surface":{"map":"disc"}}}})",
      "\"map\" of \"surface\" of \"surface\" of the request surface");
  // Depth and length have no bound in a file; sentences have.
  const std::string deep = std::string(200000, '[') + std::string(200000, ']');
  expect(R"({"op":"insert","points":)" + deep + "}", "point 0 is a list of 1");
  std::string wide = "0";
  for (int k = 0; k < 100000; ++k) wide += ",0";
  expect(R"({"op":"insert","points":[[)" + wide + "]]}", "point 0 is a list of 100001");
}

TEST(SessionHeader, TellsTheFormat) {
  EXPECT_EQ(parse_session_header(format_session_header()).format, 2);
  EXPECT_EQ(parse_session_header(R"({"batten_session":1,"unit":"mm"})").format, 1);
  EXPECT_EQ(parse_session_header(R"({"batten_session":1,"unit":"mm"})").unit, "mm");
  EXPECT_EQ(parse_session_header(R"({"batten_session":1})").unit, "m");
  for (const char* bad : {R"({"batten_session":3})", R"({"batten_session":1,"unit":5})", R"([2])", R"({)",
                          R"({"batten_session":2,"unit":"m"})"})
    EXPECT_THROW(parse_session_header(bad), InvalidInput) << bad;
}

}  // namespace
}  // namespace batten
