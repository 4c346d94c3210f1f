#include "batten/engine/engine.hpp"

#include "../session/random_project.hpp"
#include "sanitizers.hpp"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <malloc.h>
#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"
#include "batten/io/mesh_io.hpp"
#include "batten/io/scan_io.hpp"
#include "batten/pipeline/reconstruction.hpp"
#include "batten/session/edit_json.hpp"
#include "batten/session/project.hpp"
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
/// @param is_coarse few samples and triangles, for what holds at any number of them.
void add_surface(Engine& engine, bool is_coarse = false) {
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "ball.rawnet"}}, sphere_scan()).ok());
  Json network = {{"kind", "network"}}, surface = {{"kind", "surface"}};
  if (is_coarse) {
    network["step"] = {{"value", 0.06}, {"kind", "relative"}};
    surface["surface"] = {{"edge_length", {{"value", 0.06}, {"kind", "relative"}}}};
  }
  for (const auto& [name, source, request] :
       {std::tuple{"network", "o1", network}, std::tuple{"surface", "o2", surface}}) {
    const Answer derived = ask(
        engine,
        {{"op", "edit"},
         {"edit",
          {{"op", "derive"}, {"object", "o0"}, {"name", name}, {"source", source}, {"request", request}}}});
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

/// A sheet of 11 × 11 vertices over the unit square, cut into triangles.
std::string sheet() {
  std::string text = "OFF\n121 200 0\n";
  for (int i = 0; i <= 10; ++i)
    for (int j = 0; j <= 10; ++j) text += std::to_string(i / 10.0) + " " + std::to_string(j / 10.0) + " 0\n";
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      const int a = 11 * i + j;
      for (const auto& [p, q, r] : {std::tuple{a, a + 11, a + 12}, std::tuple{a, a + 12, a + 1}})
        text += "3 " + std::to_string(p) + " " + std::to_string(q) + " " + std::to_string(r) + "\n";
    }
  return text;
}

// The middle of a sheet lifted: the preview while it is dragged, and the step that it becomes.
TEST(Engine, PullsAtAMeshAsTheStepDoesThatItBecomes) {
  Engine engine;
  EXPECT_FALSE(ask(engine, {{"op", "pull"}}).ok());  // nothing is held
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "sheet.off"}}, sheet()).ok());
  const Json hold = {
      {"op", "grab"}, {"object", "o1"}, {"at", {0.5, 0.5, 0}}, {"radius", 0.12}, {"reach", 0.45}};
  const Answer held = ask(engine, hold);
  ASSERT_TRUE(held.ok()) << held.json;
  const auto moved = held.array<std::uint32_t>("moved"), fixed = held.array<std::uint32_t>("fixed");
  EXPECT_EQ(moved.size(), 5U);  // the middle and its four neighbours
  EXPECT_EQ(held.json["n_fixed"], fixed.size());
  const Answer pulled = ask(engine, {{"op", "pull"}, {"translation", {0, 0, 0.2}}});
  ASSERT_TRUE(pulled.ok()) << pulled.json;
  const auto rest = held.array<float>("positions"), now = pulled.array<float>("positions");
  ASSERT_EQ(rest.size(), now.size());
  for (const std::uint32_t v : moved) EXPECT_NEAR(now[3 * v + 2], 0.2, 1e-6);
  for (const std::uint32_t v : fixed) EXPECT_NEAR(now[3 * v + 2], 0, 1e-6);
  // The same by the request, where it keeps no detail either.
  const Json request = {{"kind", "deform"},
                        {"detail", "none"},
                        {"fixed", fixed},
                        {"moved", {{{"vertices", moved}, {"translation", {0, 0, 0.2}}}}}};
  ASSERT_TRUE(
      ask(engine,
          {{"op", "edit"},
           {"edit",
            {{"op", "derive"}, {"object", "o0"}, {"name", "bent"}, {"source", "o1"}, {"request", request}}}})
          .ok());
  const Answer bent = ask(engine, {{"op", "show"}, {"object", "o2"}});
  ASSERT_TRUE(bent.ok()) << bent.json;
  const auto wanted = bent.array<float>("positions");
  const double lift = bent.json["origin"][2].get<double>();  // the middle of what is bent is another one
  for (std::size_t v = 0; v < 121; ++v) EXPECT_NEAR(now[3 * v + 2], wanted[3 * v + 2] + lift, 1e-6);
  for (const auto& [field, value, part] :
       {std::tuple{"radius", 0.0, "radius above 0"}, std::tuple{"radius", 0.6, "reach be larger"},
        std::tuple{"reach", 9.0, "smaller reach"}}) {
    Json wrong = hold;
    wrong[field] = value;
    const Answer refused = ask(engine, wrong);
    EXPECT_FALSE(refused.ok());
    EXPECT_NE(refused.json["message"].get<std::string>().find(part), std::string::npos) << refused.json;
  }
}

TEST(Engine, MendsAMeshAndSaysWhatItHasDone) {
  Engine engine;
  std::string open = kCube;  // without its last face
  open.replace(open.find("8 12"), 4, "8 11").resize(open.size() - 8);
  const Answer opened = ask(engine, {{"op", "open"}, {"name", "box.off"}}, open);
  ASSERT_TRUE(opened.ok()) << opened.json;
  ASSERT_TRUE(ask(engine, {{"op", "edit"},
                           {"edit",
                            {{"op", "derive"},
                             {"object", "o0"},
                             {"name", "closed"},
                             {"source", "o1"},
                             {"request", {{"kind", "repair"}, {"fill_holes", 3}}}}}})
                  .ok());
  const Answer shown = ask(engine, {{"op", "show"}, {"object", "o2"}});
  ASSERT_TRUE(shown.ok()) << shown.json;
  EXPECT_EQ(shown.json["mesh"]["closed"], true);
  EXPECT_NEAR(shown.json["mesh"]["volume"].get<double>(), 1, 1e-9);
  ASSERT_EQ(shown.json["done"].size(), 1U) << shown.json["done"];
}

TEST(Engine, CutsAMeshByAPlaneAndKeepsTheCurves) {
  Engine engine;
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "cube.off"}}, kCube).ok());
  const Json cut = {{"op", "section"}, {"object", "o1"}, {"normal", {0, 0, 1}}, {"offset", 0.25}};
  const Answer found = ask(engine, cut);
  ASSERT_TRUE(found.ok()) << found.json;
  ASSERT_EQ(found.json["curves"].size(), 1U);
  EXPECT_NEAR(found.json["length"].get<double>(), 4, 1e-12);
  EXPECT_NEAR(found.json["area"].get<double>(), 1, 1e-12);
  EXPECT_FALSE(found.json.contains("edit"));
  Json kept = cut;
  kept["name"] = "cut";
  const Answer edit = ask(engine, kept);
  ASSERT_TRUE(ask(engine, {{"op", "edit"}, {"edit", edit.json["edit"]}}).ok());
  const Answer network = ask(engine, {{"op", "show"}, {"object", "o2"}});
  EXPECT_EQ(network.json["kind"], "network");
  EXPECT_EQ(network.json["curves"][0]["closed"], true);
  kept["offset"] = 7;
  EXPECT_FALSE(ask(engine, kept).ok());  // nothing to keep
}

TEST(Engine, ShowsCombsAndPrincipalDirections) {
  Engine engine;
  add_surface(engine, true);
  const Answer combs = ask(engine, {{"op", "combs"}, {"object", "o3"}});
  ASSERT_TRUE(combs.ok()) << combs.json;
  // Great circles of the unit sphere, from a scan with noise.
  const auto curvature = combs.array<float>("curvature");
  double sum = 0;
  for (const float one : curvature) sum += one;
  EXPECT_NEAR(sum / static_cast<double>(curvature.size()), 1, 0.05);
  EXPECT_EQ(combs.array<float>("roots").size(), 3 * curvature.size());
  const Answer directions = ask(engine, {{"op", "directions"}, {"object", "o3"}, {"most", 100}});
  ASSERT_TRUE(directions.ok()) << directions.json;
  const auto first = directions.array<float>("first"), second = directions.array<float>("second");
  ASSERT_EQ(first.size(), second.size());
  EXPECT_GT(first.size(), 3U * 50);
  EXPECT_LE(first.size(), 3U * 100);
  for (std::size_t i = 0; i < first.size(); i += 3) {
    EXPECT_NEAR(first[i] * second[i] + first[i + 1] * second[i + 1] + first[i + 2] * second[i + 2], 0, 1e-5);
  }
  EXPECT_FALSE(ask(engine, {{"op", "directions"}, {"object", "o3"}, {"most", 0}}).ok());
}

TEST(Engine, TellsHowSureASurfaceOfAScanIs) {
  Engine engine;
  add_surface(engine, true);
  const Answer shown = ask(engine, {{"op", "show"}, {"object", "o3"}});
  const Answer values = ask(engine, {{"op", "values"}, {"object", "o3"}, {"shading", "uncertainty"}});
  ASSERT_TRUE(values.ok()) << values.json;
  const auto list = values.array<float>("values");
  EXPECT_EQ(3 * list.size(), shown.array<float>("positions").size());
  for (const float one : list) EXPECT_GE(one, 0);
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "cube.off"}}, kCube).ok());
  const Answer none = ask(engine, {{"op", "values"}, {"object", "o4"}, {"shading", "uncertainty"}});
  EXPECT_NE(none.json["message"].get<std::string>().find("made of a scan"), std::string::npos);
}

// A circle, and an arc over it: what it would become, and what it would not.
TEST(Engine, TriesAStrokeWithoutDrawingIt) {
  Engine engine;
  const auto stroke = [](int n, double angle, double height) {
    Json points = Json::array();
    for (int i = 0; i <= n; ++i) {
      const double t = angle * i / n;
      points.push_back({std::cos(t), height > 0 ? 0.0 : std::sin(t), height * std::sin(t)});
    }
    return points;
  };
  const double pi = std::acos(-1.0);
  ASSERT_TRUE(ask(engine, {{"op", "edit"},
                           {"edit",
                            {{"op", "add"},
                             {"object", "o0"},
                             {"kind", "model"},
                             {"name", "m"},
                             {"unit", "mm"},
                             {"content", Json::object()}}}})
                  .ok());
  const Json outline = {{"op", "insert"}, {"object", "o1"}, {"points", stroke(60, 2 * pi, 0)}};
  const Answer first = ask(engine, {{"op", "try"}, {"edit", outline}});
  ASSERT_TRUE(first.ok()) << first.json;
  EXPECT_EQ(first.json["accepted"], true);
  EXPECT_EQ(first.json["faces"], 1);
  EXPECT_TRUE(first.json["meets"].empty());
  EXPECT_EQ(ask(engine, {{"op", "show"}, {"object", "o1"}}).json["curves"].size(), 0U);  // only tried
  ASSERT_TRUE(ask(engine, {{"op", "edit"}, {"edit", outline}}).ok());
  const Answer over =
      ask(engine,
          {{"op", "try"}, {"edit", {{"op", "insert"}, {"object", "o1"}, {"points", stroke(30, pi, 0.8)}}}});
  ASSERT_EQ(over.json["accepted"], true) << over.json;
  ASSERT_EQ(over.json["meets"].size(), 2U) << over.json;
  for (const Json& met : over.json["meets"]) EXPECT_EQ(met["curve"], "c0");
  EXPECT_GT(over.array<float>("positions").size(), 30U);
  const Answer inside = ask(
      engine,
      {{"op", "try"},
       {"edit", {{"op", "insert"}, {"object", "o1"}, {"points", {{0, 0, 0}, {0.1, 0.05, 0}, {0.2, 0, 0}}}}}});
  EXPECT_EQ(inside.json["accepted"], false);
  EXPECT_FALSE(inside.json["reason"].get<std::string>().empty());
  EXPECT_FALSE(inside.json["remedy"].get<std::string>().empty());
}

TEST(Engine, SavesStepWhereItIsGivenAWriter) {
  Engine plain, cad([](const RequestResult&made, const std::string&unit, const Progress&) {
    return concat("unit '", unit, "' patches ", std::get<CurvesSurface>(made).surface.n_cycles);
  });
  add_surface(plain, true);
  add_surface(cad, true);
  const Json message = {{"op", "save"}, {"object", "o3"}, {"format", "step"}};
  EXPECT_FALSE(ask(plain, message).ok());
  const Answer saved = ask(cad, message);
  ASSERT_TRUE(saved.ok()) << saved.json;
  const auto bytes = saved.array<char>("file");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "unit '' patches 8");
  const Json objects = ask(cad, {{"op", "document"}}).json["objects"];
  EXPECT_EQ(objects[2]["formats"].back(), "step");
  EXPECT_NE(objects[1]["formats"].back(), "step");
}

// 500 commands of every kind without a plan, as messages; then everything undone and done again. Documents
// are compared whole, numbers bit for bit, on the way back at every tenth place.
TEST(Engine, UndoesAndRedoesAnythingBitForBit) {
  Engine engine;
  const auto document = [&] {
    const auto bytes = ask(engine, {{"op", "save"}}).array<char>("file");
    return parse_project(std::string(bytes.begin(), bytes.end()), "project.batten").document;
  };
  const auto send = [&](const std::string& line) {
    return ask(engine, {{"op", "edit"}, {"edit", Json::parse(line)}}).ok();
  };
  test::RandomProject project(11);
  Document shadow;  // what the next command is made for
  int n_done = 0;
  constexpr int kCommands = test::repeated(500, 60);
  for (int k = 0; k < kCommands; ++k) {
    Edit edit = project.edit(shadow);
    std::visit(
        [](auto& one) {
          if constexpr (requires { one.drag; }) one.drag = 0;
        },
        edit);
    // The engine finds another name where one is taken; a document refuses.
    if (auto* derive = std::get_if<DeriveEdit>(&edit)) derive->name += concat(" ", k);
    bool is_done = true;
    try {
      shadow.apply(edit);
    } catch (const RefusedEdit&) {
      is_done = false;
    }
    ASSERT_EQ(send(format_edit(edit)), is_done) << k << ": " << format_edit(edit);
    n_done += is_done ? 1 : 0;
  }
  EXPECT_GT(n_done, kCommands / 2);
  EXPECT_TRUE(document() == shadow);
  const auto in_step = [&](const Edit& edit) {
    shadow.apply(edit);
    return send(format_edit(edit));
  };
  while (shadow.can_redo()) ASSERT_TRUE(in_step(RedoEdit{}));
  const Document last = document();
  std::vector<std::pair<int, Document>> places;
  int n_undone = 0;
  for (; shadow.can_undo(); ++n_undone) {
    if (n_undone % 10 == 0) places.emplace_back(n_undone, document());
    ASSERT_TRUE(in_step(UndoEdit{}));
  }
  EXPECT_GT(n_undone, kCommands / 10);
  EXPECT_TRUE(ask(engine, {{"op", "document"}}).json["objects"].empty());
  for (; shadow.can_redo(); --n_undone) {
    if (!places.empty() && places.back().first == n_undone) {
      EXPECT_TRUE(document() == places.back().second) << n_undone;
      places.pop_back();
    }
    ASSERT_TRUE(in_step(RedoEdit{}));
  }
  EXPECT_TRUE(document() == last);
  EXPECT_TRUE(document() == shadow);
}

TEST(Engine, GivesBackItsMemoryWhenModelsAreClosed) {
#if defined(BATTEN_SANITIZED) || !defined(__GLIBC__)
  GTEST_SKIP() << "sanitizers keep their own account of memory";
#else
  constexpr int kSide = 175;  // 2 · 174² triangles
  TriangleMesh mesh;
  mesh.positions.resize(kSide * kSide, 3);
  for (int i = 0; i < kSide * kSide; ++i) mesh.positions.row(i) << i % kSide, i / kSide, 0;
  mesh.triangles.resize(2 * (kSide - 1) * (kSide - 1), 3);
  for (int y = 0, t = 0; y + 1 < kSide; ++y)
    for (int x = 0; x + 1 < kSide; ++x) {
      const int v = y * kSide + x;
      mesh.triangles.row(t++) << v, v + 1, v + kSide + 1;
      mesh.triangles.row(t++) << v, v + kSide + 1, v + kSide;
    }
  const std::string file = format_mesh(mesh, MeshFormat::Ply);
  const auto used = [] { return static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd); };
  const auto open_and_close = [&](bool is_shown) {
    Engine engine;
    ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "sheet.ply"}}, file).ok());
    if (is_shown) {
      ASSERT_TRUE(ask(engine, {{"op", "show"}, {"object", "o1"}}).ok());
    }
  };
  open_and_close(true);
  const double before = used();
  for (int i = 0; i < 200; ++i) open_and_close(i % 20 == 0);
  EXPECT_NEAR(used() / before, 1, 0.1);
#endif
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

TEST(Engine, HoldsNothingOfTheProjectBeforeWhenAnotherTakesItsPlace) {
  Engine engine;
  ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", "sheet.off"}}, sheet()).ok());
  const auto bytes = ask(engine, {{"op", "save"}}).array<char>("file");
  const Json pull = {{"op", "pull"}, {"translation", {0, 0, 0.2}}};
  for (const auto& [name, file] :
       {std::pair<std::string, std::string>{"sheet.batten", {bytes.begin(), bytes.end()}},
        {"empty.jsonl", R"({"batten_session":1,"unit":"mm"})"}}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(
        ask(engine,
            {{"op", "grab"}, {"object", "o1"}, {"at", {0.5, 0.5, 0}}, {"radius", 0.12}, {"reach", 0.45}})
            .ok());
    ASSERT_TRUE(ask(engine, pull).ok());
    ASSERT_TRUE(ask(engine, {{"op", "open"}, {"name", name}}, file).ok());
    EXPECT_FALSE(ask(engine, pull).ok());
  }
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
