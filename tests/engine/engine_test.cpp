#include "batten/engine/engine.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "batten/io/mesh_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/pipeline/reconstruction.hpp"
#include "batten/simulation/shapes.hpp"
#include "batten/simulation/simulate.hpp"

namespace batten {
namespace {

using Json = nlohmann::json;

struct Answer {
  Json json;
  std::map<std::string, ReplyArray> arrays;

  bool ok() const { return json.at("ok").get<bool>(); }
  template <typename T>
  std::vector<T> array(const std::string& name) const {
    const std::vector<std::byte>& bytes = arrays.at(name).bytes;
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }
};

Answer ask(Engine& engine, const Json& message, const std::string& bytes = {},
           const Progress& progress = {}) {
  Reply reply = engine.handle(message.dump(), bytes, progress);
  Answer answer{Json::parse(reply.text), {}};
  for (ReplyArray& array : reply.arrays) answer.arrays[array.name] = array;
  return answer;
}

/// A unit cube of 8 vertices and 12 triangles.
constexpr const char* kCube =
    "OFF\n8 12 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
    "3 0 2 1\n3 0 3 2\n3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 "
    "4 7\n";

std::string sphere_scan() {
  SimulateOptions options;
  options.seed = 3;
  options.orientation_noise = 0.01;
  return format_rawnet(simulate_scan(trace_shape(AnalyticShape::Sphere), options).scan);
}

/// A scan with its network and surface: o1, o2, o3.
void add_surface(Engine& engine) {
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "ball.rawnet"}}, sphere_scan()).ok());
  for (const auto& [name, source, kind] :
       {std::tuple{"network", "o1", "network"}, std::tuple{"surface", "o2", "surface"}}) {
    const Answer derived = ask(engine, {{"op", "edit"},
                                        {"edit",
                                         {{"op", "derive"},
                                          {"object", "o0"},
                                          {"name", name},
                                          {"source", source},
                                          {"request", {{"kind", kind}}}}}});
    ASSERT_TRUE(derived.ok()) << derived.json;
  }
}

TEST(Engine, ShowsAFileThatItOpened) {
  Engine engine;
  const Answer opened = ask(engine, {{"op", "open"}, {"name", "parts/cube.off"}}, kCube);
  ASSERT_TRUE(opened.ok()) << opened.json;
  EXPECT_EQ(opened.json["object"], "o1");
  const Answer shown = ask(engine, {{"op", "show"}, {"object", "o1"}});
  ASSERT_TRUE(shown.ok()) << shown.json;
  EXPECT_EQ(shown.json["kind"], "mesh");
  EXPECT_EQ(shown.json["origin"], Json({0.5, 0.5, 0.5}));
  EXPECT_EQ(shown.json["mesh"]["n_triangles"], 12);
  EXPECT_EQ(shown.json["mesh"]["closed"], true);
  // Three faces meet at every corner, each with a normal of its own.
  const auto positions = shown.array<float>("positions"), normals = shown.array<float>("normals");
  const auto triangles = shown.array<std::uint32_t>("triangles"),
             vertex = shown.array<std::uint32_t>("vertex");
  EXPECT_EQ(positions.size(), 3U * 24);
  EXPECT_EQ(vertex.size(), 24U);
  ASSERT_EQ(triangles.size(), 36U);
  for (std::size_t i = 0; i < 36; ++i) {
    const float* p = &positions[3 * triangles[i]];
    const float* n = &normals[3 * triangles[i]];
    EXPECT_NEAR(std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]), 1, 1e-6);
    EXPECT_NEAR(p[0] * n[0] + p[1] * n[1] + p[2] * n[2], 0.5, 1e-6);  // outward, on the plane of the face
  }
}

TEST(Engine, MakesTheSurfaceThatReconstructMakes) {
  Engine engine;
  add_surface(engine);
  const Answer shown = ask(engine, {{"op", "show"}, {"object", "o3"}});
  ASSERT_TRUE(shown.ok()) << shown.json;
  const Reconstruction wanted = reconstruct(parse_rawnet(sphere_scan(), "ball"));
  EXPECT_EQ(shown.json["mesh"]["n_triangles"], wanted.surface.mesh.n_triangles());
  EXPECT_EQ(shown.json["n_patches"], wanted.surface.n_cycles);
  ASSERT_FALSE(shown.json["times"].empty());
  for (const Json& time : shown.json["times"]) {
    EXPECT_FALSE(time["stage"].get<std::string>().empty());
    EXPECT_GE(time["seconds"].get<double>(), 0);
  }
  const Answer saved = ask(engine, {{"op", "save"}, {"object", "o3"}, {"format", "ply"}});
  ASSERT_TRUE(saved.ok()) << saved.json;
  const auto bytes = saved.array<char>("file");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), format_mesh(wanted.surface.mesh, MeshFormat::Ply));
}

TEST(Engine, FollowsASliderWithTheSurfaceMovedNotBuilt) {
  Engine engine;
  add_surface(engine);
  const auto request = [](double lambda) -> Json {
    return {{"op", "edit"},
            {"drag", 7},
            {"edit",
             {{"op", "request"},
              {"object", "o2"},
              {"request", {{"kind", "network"}, {"weights", "given"}, {"lambda", lambda}, {"mu", 1}}}}}};
  };
  ASSERT_TRUE(ask(engine, request(0.1)).ok());
  const Answer first = ask(engine, {{"op", "follow"}, {"object", "o3"}, {"moving", true}});
  ASSERT_TRUE(first.ok()) << first.json;
  EXPECT_EQ(first.json["rebuilt"], true);
  EXPECT_TRUE(first.arrays.contains("triangles"));
  ASSERT_TRUE(ask(engine, request(0.2)).ok());
  const Answer second = ask(engine, {{"op", "follow"}, {"object", "o3"}, {"moving", true}});
  ASSERT_TRUE(second.ok()) << second.json;
  EXPECT_EQ(second.json["rebuilt"], false);
  EXPECT_FALSE(second.arrays.contains("triangles"));
  EXPECT_EQ(first.array<float>("positions").size(), second.array<float>("positions").size());
  EXPECT_NE(first.array<float>("positions"), second.array<float>("positions"));
  // The whole drag is one edit.
  const Answer undone = ask(engine, {{"op", "edit"}, {"edit", {{"op", "undo"}}}});
  ASSERT_TRUE(undone.ok());
  const Answer document = ask(engine, {{"op", "document"}});
  EXPECT_EQ(document.json["objects"][1]["request"]["weights"], "auto");
}

TEST(Engine, TellsPerCurveWhetherTheSurfaceIsSmooth) {
  Engine engine;
  add_surface(engine);
  const double degree = std::acos(-1.0) / 180;
  const Answer fine = ask(engine, {{"op", "continuity"}, {"object", "o3"}, {"tolerance", 30 * degree}});
  ASSERT_TRUE(fine.ok()) << fine.json;
  EXPECT_GT(fine.json["n_checked"].get<int>(), 0);
  EXPECT_EQ(fine.json["n_failed"], 0);
  const Answer strict = ask(engine, {{"op", "continuity"}, {"object", "o3"}, {"tolerance", 1e-9}});
  EXPECT_EQ(strict.json["n_failed"], strict.json["n_checked"]);
}

TEST(Engine, GivesTheValuesBehindColours) {
  Engine engine;
  add_surface(engine);
  const Answer shown = ask(engine, {{"op", "show"}, {"object", "o3"}});
  const Answer values = ask(engine, {{"op", "values"}, {"object", "o3"}, {"shading", "mean-curvature"}});
  ASSERT_TRUE(values.ok()) << values.json;
  const auto list = values.array<float>("values");
  EXPECT_EQ(3 * list.size(), shown.array<float>("positions").size());
  EXPECT_EQ(values.json["low"].get<double>(), -values.json["high"].get<double>());
  const Answer none = ask(engine, {{"op", "values"}, {"object", "o3"}, {"shading", "isophotes"}});
  EXPECT_FALSE(none.ok());
}

TEST(Engine, AnswersWhatGoesWrongInWords) {
  Engine engine;
  const auto message_of = [&](const std::string& text, const std::string& bytes = {}) {
    const Json json = Json::parse(engine.handle(text, bytes).text);
    EXPECT_EQ(json["ok"], false) << text;
    return json.value("message", "");
  };
  EXPECT_EQ(message_of("{"), "the message is no JSON object");
  EXPECT_EQ(message_of("{}"), "the message has no 'op'");
  EXPECT_NE(message_of(R"({"op":"dance"})").find("unknown op 'dance'; known are "), std::string::npos);
  EXPECT_EQ(message_of(R"({"op":"show","object":"o7"})"), "there is no object 'o7'");
  EXPECT_NE(message_of(R"({"op":"show","object":3})").find("must be text"), std::string::npos);
  EXPECT_NE(message_of(R"({"op":"open","name":"a.ply"})", "ply\nformat nonsense").find("a.ply"),
            std::string::npos);
  EXPECT_NE(message_of(R"({"op":"edit","edit":{"op":"undo"}})"), "");
  // Nothing of it has changed the project.
  EXPECT_TRUE(ask(engine, {{"op", "document"}}).json["objects"].empty());
}

TEST(Engine, StopsWhereProgressSaysSo) {
  Engine engine;
  add_surface(engine);
  const Answer stopped = ask(engine, {{"op", "show"}, {"object", "o3"}}, {},
                             Progress([](std::string_view, double) { return false; }));
  EXPECT_FALSE(stopped.ok());
  EXPECT_EQ(stopped.json["kind"], "cancelled");
  EXPECT_TRUE(ask(engine, {{"op", "show"}, {"object", "o3"}}).ok());
}

TEST(Engine, PlaysARecordedSessionAndSaysWhatItRefused) {
  const std::string session =
      R"({"batten_session":1,"unit":"mm"}
{"op":"insert","points":[[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0,0,0]]}
{"op":"delete","curve":"c7"}
)";
  Engine engine;
  const Answer opened = ask(engine, {{"op", "open"}, {"name", "strokes.jsonl"}}, session);
  ASSERT_TRUE(opened.ok()) << opened.json;
  EXPECT_EQ(opened.json["replaced"], true);
  ASSERT_EQ(opened.json["warnings"].size(), 1U) << opened.json;
  EXPECT_EQ(opened.json["warnings"][0].get<std::string>().rfind("line 3 refused: ", 0), 0U) << opened.json;
  const Json document = ask(engine, {{"op", "document"}}).json;
  ASSERT_EQ(document["objects"].size(), 1U);
  EXPECT_EQ(document["objects"][0]["kind"], "model");
  EXPECT_EQ(document["objects"][0]["unit"], "mm");
  // What is no session says so, and takes nothing away.
  EXPECT_FALSE(ask(engine, {{"op", "open"}, {"name", "other.jsonl"}}, "nonsense").ok());
  EXPECT_EQ(ask(engine, {{"op", "document"}}).json["objects"].size(), 1U);
}

TEST(Engine, KeepsAProjectThroughItsFile) {
  Engine engine;
  add_surface(engine);
  const auto bytes = ask(engine, {{"op", "save"}}).array<char>("file");
  Engine other;
  const Answer opened =
      ask(other, {{"op", "open"}, {"name", "ball.batten"}}, std::string(bytes.begin(), bytes.end()));
  ASSERT_TRUE(opened.ok()) << opened.json;
  EXPECT_EQ(ask(other, {{"op", "document"}}).json["objects"].size(), 3U);
}

}  // namespace
}  // namespace batten
