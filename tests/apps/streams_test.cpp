#include "apps/run_batten.hpp"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace batten::test {
namespace {

/// Makes scan.rawnet, truth.ply and truth.net.
void make_samples() {
  ASSERT_EQ(run_batten("simulate sphere -o scan.rawnet --truth truth.ply --truth-network truth.net --step 4% "
                       "--truth-step 4% --truth-edge 15%")
                .exit_code,
            0);
}

TEST(Streams, GiveTheBytesOfFiles) {
  make_samples();
  const struct {
    const char *by_file, *file, *by_stream;
  } kLines[] = {
      {"convert truth.ply a.obj", "a.obj", "convert - obj:- < truth.ply"},
      {"convert truth.net a.json", "a.json", "convert - - < truth.net"},
      {"convert scan.rawnet b.rawnet", "b.rawnet", "convert - rawnet:- < scan.rawnet"},
      {"fair truth.ply -o c.ply", "c.ply", "fair - -o - < truth.ply"},
      {"surface truth.net -o d.off", "d.off", "surface - -o off:- < truth.net"},
      {"network scan.rawnet -o e.json", "e.json", "network - -o - < scan.rawnet"},
      {"render truth.ply -o f.png --size 64x64", "f.png", "render - -o - --size 64x64 < truth.ply"},
      {"simulate torus -o g.rawnet --step 5%", "g.rawnet", "simulate torus -o - --step 5%"},
      {"subdivide truth.ply -o h.obj --levels 1", "h.obj", "subdivide - -o obj:- --levels 1 < truth.ply"},
  };
  for (const auto& line : kLines) {
    const auto by_file = run_batten(line.by_file);
    ASSERT_EQ(by_file.exit_code, 0) << line.by_file << by_file.err;
    const auto by_stream = run_batten(line.by_stream);
    EXPECT_EQ(by_stream.exit_code, 0) << line.by_stream << by_stream.err;
    EXPECT_EQ(by_stream.out, read_file(line.file)) << line.by_stream;
    EXPECT_FALSE(by_stream.err.empty()) << "what is said goes beside";
  }
}

TEST(Streams, TheObjectOfJsonGoesBeside) {
  make_samples();
  const auto run = run_batten("convert - obj:- --json < truth.ply");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.out.find("\nv "), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(run.err, nullptr, false).is_object()) << run.err;
}

TEST(Streams, CompressedAndUnknownInput) {
  make_samples();
  EXPECT_EQ(run_batten("convert truth.ply a.obj && gzip -k a.obj").exit_code, 0);
  const auto packed = run_batten("info - --json < a.obj.gz");
  EXPECT_EQ(packed.exit_code, 0) << packed.err;
  const auto empty = run_batten("info -");
  EXPECT_EQ(empty.exit_code, 3);
  write_file("hello.txt", "hello world\n");
  const auto unknown = run_batten("surface - -o s.ply < hello.txt");
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_NE(unknown.err.find("not recognised"), std::string::npos) << unknown.err;
}

TEST(Limits, AreTestedBeforeTheWork) {
  make_samples();
  for (const char* line :
       {"surface truth.net -o s.ply --edge-length 1e-9",
        "reconstruct scan.rawnet -o s.ply --edge-length 1e-9",
        "surface truth.net -o s.ply --max-triangles 100", "network scan.rawnet -o n.net --step 1e-9",
        "simulate torus -o r.rawnet --step 1e-9", "remesh truth.ply -o r.ply --edge 1e-9",
        "convert truth.net c.net --resample 1e-9"}) {
    const auto run = run_batten(line);
    EXPECT_EQ(run.exit_code, 3) << line << run.err;
    EXPECT_TRUE(run.err.find("more than") != std::string::npos ||
                run.err.find("would take") != std::string::npos)
        << run.err;
  }
  // The remedy works.
  EXPECT_EQ(run_batten("surface truth.net -o s.ply --max-triangles 100000").exit_code, 0);
}

}  // namespace
}  // namespace batten::test
