#include "studio/page.hpp"

#include "scratch.hpp"
#include "studio/client.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "batten/core/error.hpp"

namespace batten::test {
namespace {

namespace fs = std::filesystem;

/// A page of four files; what lies beside it is none of it.
std::string some_page() {
  const fs::path page = fs::path(scratch()) / "page" / "dist";
  fs::create_directories(page / "assets");
  std::ofstream(page / "index.html") << "<!doctype html><title>page</title>";
  std::ofstream(page / "sw.js") << "self;";
  std::ofstream(page / "assets/index-1a2b.mjs") << "export {};";
  std::ofstream(page / "assets/engine-3c4d.wasm") << "wasm";
  std::ofstream(page.parent_path() / "secret.html") << "secret";
  std::error_code ignored;
  fs::create_symlink("../secret.html", page / "link.html", ignored);
  return page.string();
}

studio::ServerOptions with_page() {
  studio::ServerOptions options;
  options.page_folder = some_page();
  return options;
}

TEST(Page, FilesHaveTheirTypesAndRules) {
  Studio studio(with_page());
  const struct {
    const char *target, *type, *cache;
  } kFiles[] = {
      {"/", "text/html; charset=utf-8", "no-cache"},
      {"/index.html", "text/html; charset=utf-8", "no-cache"},
      {"/?x=1", "text/html; charset=utf-8", "no-cache"},
      {"/sw.js", "text/javascript; charset=utf-8", "no-cache"},
      {"/assets/index-1a2b.mjs", "text/javascript; charset=utf-8", "public, max-age=31536000, immutable"},
      {"/assets/engine-3c4d.wasm", "application/wasm", "public, max-age=31536000, immutable"}};
  for (const auto& file : kFiles) {
    const HttpAnswer answer = studio.ask("GET", file.target);
    EXPECT_EQ(answer.status, 200) << file.target;
    EXPECT_EQ(answer.header("Content-Type"), file.type) << file.target;
    EXPECT_EQ(answer.header("Cache-Control"), file.cache) << file.target;
    EXPECT_EQ(answer.header("X-Content-Type-Options"), "nosniff");
    EXPECT_EQ(answer.header("Cross-Origin-Opener-Policy"), "same-origin");
    EXPECT_EQ(answer.header("Cross-Origin-Embedder-Policy"), "require-corp");
    EXPECT_NE(answer.header("Content-Security-Policy").find("default-src 'self'"), std::string::npos);
    EXPECT_EQ(answer.head.find("Access-Control"), std::string::npos);
  }
}

TEST(Page, HeadAndTagsSaveTheBody) {
  Studio studio(with_page());
  const HttpAnswer whole = studio.ask("GET", "/"), head = studio.ask("HEAD", "/");
  EXPECT_EQ(head.status, 200);
  EXPECT_EQ(head.header("Content-Length"), std::to_string(whole.body.size()));
  const std::string tag = whole.header("ETag");
  for (const std::string& known : {tag, "\"other\", W/" + tag, std::string("*")})
    EXPECT_EQ(studio.ask("GET", "/", "If-None-Match: " + known + "\r\n").status, 304) << known;
  EXPECT_EQ(studio.ask("GET", "/", "If-None-Match: \"other\"\r\n").status, 200);
  EXPECT_NE(studio.ask("GET", "/sw.js").header("ETag"), tag);
}

TEST(Page, PathsNeverReachTheFileSystem) {
  Studio studio(with_page());
  for (const char* target :
       {"/../secret.html", "/..%2fsecret.html", "/%2e%2e/secret.html", "/assets/../../secret.html",
        "/assets/..%2F..%2Fsecret.html", "/..\\secret.html", "//etc/passwd", "/%2fetc%2fpasswd", "/link.html",
        "/assets", "/assets/", "/./index.html", "/index.html/", "/index.html%00", "/INDEX.HTML", "/.", "/..",
        "/nothing.js"}) {
    const HttpAnswer answer = studio.ask("GET", target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_EQ(answer.body.find("secret\n"), std::string::npos);
  }
  EXPECT_THROW(studio::Page::of_folder(scratch() + "/nowhere"), FileError);
}

// What the build has put into the program is there, packed and not; or the sentence how to build it.
TEST(Page, TheProgramHoldsAPageOrSaysHowToGetOne) {
  Studio studio;
  const HttpAnswer plain = studio.ask("GET", "/");
  if (!studio.server().has_page()) {
    EXPECT_EQ(plain.status, 503);
    EXPECT_NE(plain.body.find("tools/build web"), std::string::npos);
    EXPECT_EQ(studio.ask("GET", "/sw.js").status, 404);
    return;
  }
  EXPECT_EQ(plain.status, 200);
  const HttpAnswer packed = studio.ask("GET", "/", "Accept-Encoding: br, gzip;q=0.8\r\n");
  if (packed.header("Content-Encoding").empty()) return;  // a page too short to be worth it
  EXPECT_EQ(packed.body.substr(0, 2), "\x1f\x8b");
  EXPECT_LT(packed.body.size(), plain.body.size());
  EXPECT_NE(packed.header("ETag"), plain.header("ETag"));
  EXPECT_EQ(studio.ask("GET", "/", "Accept-Encoding: gzip;q=0\r\n").body, plain.body);
}

}  // namespace
}  // namespace batten::test
