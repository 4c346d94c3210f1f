#include "studio/server.hpp"

#include "scratch.hpp"
#include "studio/client.hpp"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

// The dangers of docs/studio-server.md#safety, one test each; after each of them the server answers as
// before.
namespace batten::test {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;

/// An engine that answers at once: the tests of this file are about who may ask.
studio::Handle quick_engine() {
  return [](std::string_view, std::string_view, const Progress&) { return Reply{R"({"ok":true})", {}}; };
}

studio::ServerOptions quick() {
  studio::ServerOptions options;
  options.engine = quick_engine;
  options.limits.head = 150ms;
  options.limits.body = 200ms;
  options.limits.farewell = 100ms;
  return options;
}

studio::ServerOptions with_folder() {
  studio::ServerOptions options = quick();
  const std::filesystem::path folder = std::filesystem::path(scratch()) / "work";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "hull.ply") << "hull";
  options.place = folder.string();
  return options;
}

void expect_alive(Studio& studio) {
  EXPECT_EQ(studio.ask_as_page("GET", "/files").status, 200);
}

TEST(Dangers, AnotherHostIsMisdirected) {
  Studio studio(with_folder());
  for (const char* host : {"evil.example", "evil.example:8617", "127.0.0.1", "localhost", ""})
    for (const char* target : {"/", "/files", "/session"}) {
      const HttpAnswer answer =
          studio.ask("GET", target, concat("Host: ", host, "\r\nCookie: ", studio.cookie(), "\r\n"));
      EXPECT_EQ(answer.status, 421) << host << target;
    }
  Wire without(studio.server().port());
  without.send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(without.answer().status, 421);
  Wire twice(studio.server().port());
  twice.send("GET / HTTP/1.1\r\nHost: " + studio.host() + "\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(twice.answer().status, 400);
  EXPECT_NE(studio.told().find("421 GET /files"), std::string::npos) << studio.told();
  expect_alive(studio);
}

TEST(Dangers, AnotherOriginIsRefusedWithTheCookieToo) {
  Studio studio(with_folder());
  for (const std::string& origin :
       {std::string("Origin: http://evil.example\r\n"), std::string("Origin: null\r\n"),
        concat("Origin: http://localhost:", studio.server().port(), "\r\n"),
        concat("Origin: https://", studio.host(), "\r\n"), std::string()}) {
    const std::string headers = origin + "Cookie: " + studio.cookie() + "\r\n";
    EXPECT_EQ(studio.ask("POST", "/files?name=a.ply", headers, "x").status, 403) << origin;
    EXPECT_EQ(studio.ask("POST", "/session", headers, "{}").status, 403) << origin;
    EXPECT_EQ(
        studio
            .ask("GET", "/engine",
                 headers + "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n")
            .status,
        403)
        << origin;
    EXPECT_EQ(studio.ask("GET", "/files", headers).status, origin.empty() ? 200 : 403) << origin;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch() + "/work/a.ply"));
  expect_alive(studio);
}

TEST(Dangers, WithoutTheCookieThereIsThePageAlone) {
  Studio studio(with_folder());
  const std::string origin = "Origin: " + studio.origin() + "\r\n";
  for (const std::string& cookie :
       {std::string(), std::string("Cookie: batten-1=0\r\n"),
        concat("Cookie: batten-", studio.server().port(), "=", studio.secret(), "\r\n")}) {
    EXPECT_EQ(studio.ask("GET", "/files", cookie).status, 401);
    EXPECT_EQ(studio.ask("GET", "/files/0", cookie).status, 401);
    EXPECT_EQ(studio.ask("POST", "/files?name=a.ply", cookie + origin, "x").status, 401);
    EXPECT_EQ(studio.ask("GET", "/session", cookie).status, 401);
    EXPECT_EQ(studio
                  .ask("GET", "/engine",
                       cookie + origin +
                           "Connection: Upgrade\r\nUpgrade: websocket\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n")
                  .status,
              401);
  }
  expect_alive(studio);
}

TEST(Dangers, TheSecretIsWrongOrWasUsed) {
  Studio studio(with_folder());
  const std::string origin = "Origin: " + studio.origin() + "\r\n";
  const auto trade = [&](const std::string& body, const std::string& headers = {}) {
    return studio.ask("POST", "/session", origin + headers, body);
  };
  const std::string right = "{\"secret\":\"" + studio.secret() + "\"}";
  EXPECT_EQ(trade("{\"secret\":\"" + std::string(32, '0') + "\"}").status, 403);
  for (const char* body : {"", "{}", "[]", "{\"secret\":1}", "secret"})
    EXPECT_EQ(trade(body).status, 400) << body;
  EXPECT_EQ(trade(std::string(2000, ' ')).status, 413);
  const HttpAnswer first = trade(right);
  EXPECT_EQ(first.status, 200);
  EXPECT_NE(first.header("Set-Cookie").find("SameSite=Strict"), std::string::npos);
  const HttpAnswer again = trade(right);
  EXPECT_EQ(again.status, 403) << "another browser, or somebody who read the address";
  EXPECT_TRUE(again.header("Set-Cookie").empty());
  const std::string set = first.header("Set-Cookie");
  EXPECT_EQ(trade(right, "Cookie: " + set.substr(0, set.find(';')) + "\r\n").status, 200)
      << "the same window, loaded again";
  EXPECT_EQ(studio.ask("GET", "/files", "Cookie: " + set.substr(0, set.find(';')) + "\r\n").status, 200);
}

TEST(Dangers, FilesAreNumbersAndNothingElse) {
  Studio studio(with_folder());
  const Json list = Json::parse(studio.ask_as_page("GET", "/files").body);
  ASSERT_EQ(list["files"].size(), 1U);
  EXPECT_EQ(list["files"][0]["name"], "hull.ply");
  EXPECT_EQ(list["folder"], "work");
  const HttpAnswer hull = studio.ask_as_page("GET", "/files/0");
  EXPECT_EQ(hull.body, "hull");
  EXPECT_EQ(hull.header("Content-Type"), "application/octet-stream");
  EXPECT_EQ(studio.ask_as_page("HEAD", "/files/0").header("Content-Length"), "4");
  for (const char* target :
       {"/files/1", "/files/-1", "/files/00000000", "/files/999999999999999999999", "/files/", "/files/0/..",
        "/files/..", "/files/../files/0", "/files/%30", "/files/..%2f..%2fetc%2fpasswd", "/files/hull.ply",
        "/files/0x0", "/files/+0", "/files/0%00"})
    EXPECT_EQ(studio.ask_as_page("GET", target).status, 404) << target;
  expect_alive(studio);
}

TEST(Dangers, WrittenFilesStayInTheFolder) {
  Studio studio(with_folder());
  const HttpAnswer made = studio.ask_as_page("POST", "/files?name=new%20one.ply", "new");
  EXPECT_EQ(made.status, 201) << made.body;
  const Json json = Json::parse(made.body);
  EXPECT_EQ(studio.ask_as_page("GET", concat("/files/", json["number"].get<int>())).body, "new");
  EXPECT_EQ(studio.ask_as_page("POST", "/files?name=new+one.ply", "x").status, 409);
  EXPECT_EQ(studio.ask_as_page("POST", "/files?name=new+one.ply&replace=0", "x").status, 409);
  EXPECT_EQ(studio.ask_as_page("POST", "/files?name=new+one.ply&replace=1", "other").status, 201);
  EXPECT_EQ(studio.ask_as_page("GET", concat("/files/", json["number"].get<int>())).body, "other");
  for (const char* query : {"", "?name=", "?name=..%2Fx.ply", "?name=%2e%2e%2fx.ply", "?name=../x.ply",
                            "?name=%2Ftmp%2Fx.ply", "?name=x.ply%00", "?name=x.sh", "?name=%zz.ply",
                            "?name=x.ply%2", "?name=.x.ply", "?name=a%2F..%2Fx.ply", "?name=..%5Cx.ply"})
    EXPECT_EQ(studio.ask_as_page("POST", std::string("/files") + query, "x").status, 400) << query;
  EXPECT_FALSE(std::filesystem::exists(scratch() + "/x.ply"));
  Studio without(quick());
  EXPECT_EQ(without.ask_as_page("POST", "/files?name=x.ply", "x").status, 404);
  EXPECT_EQ(Json::parse(without.ask_as_page("GET", "/files").body)["folder"], nullptr);
}

TEST(Dangers, UnknownMethodsAndSocketsAreNamed) {
  Studio studio(with_folder());
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "BREW", "get", "G"}) {
    const HttpAnswer answer = studio.ask_as_page(method, "/files/0");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.header("Allow"), "GET, HEAD");
    EXPECT_TRUE(answer.header("Access-Control-Allow-Origin").empty());
  }
  EXPECT_EQ(studio.ask_as_page("POST", "/").status, 405);
  EXPECT_EQ(studio.ask_as_page("GET", "/engine").status, 426);
  EXPECT_EQ(studio
                .ask("GET", "/other",
                     "Origin: " + studio.origin() + "\r\nCookie: " + studio.cookie() +
                         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: "
                         "13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n")
                .status,
            404);
  expect_alive(studio);
}

TEST(Dangers, MalformedHttpIsAnsweredAndClosed) {
  Studio studio(with_folder());
  const std::string host = "Host: " + studio.host() + "\r\n";
  const struct {
    std::string bytes;
    int status;
  } kRequests[] = {{"hello\r\n\r\n", 400},
                   {std::string("\0\1\2\3\r\n\r\n", 8), 400},
                   {"GET / HTTP/9.9\r\n" + host + "\r\n", 400},
                   {"GET http://" + studio.host() + "/ HTTP/1.1\r\n" + host + "\r\n", 400},
                   {"GET / HTTP/1.1\r\n" + host + "no colon\r\n\r\n", 400},
                   {"GET / HTTP/1.1\r\n" + host + "Content-Length: -1\r\n\r\n", 400},
                   {"GET / HTTP/1.1\r\n" + host + "Content-Length: 1\r\nContent-Length: 2\r\n\r\n", 400},
                   {"GET / HTTP/1.1\r\n" + host + "Content-Length: 10\r\n\r\n", 413},
                   {"GET / HTTP/1.1\r\n" + host + "Long: " + std::string(9000, 'x') + "\r\n\r\n", 431},
                   {"POST /session HTTP/1.1\r\n" + host + "Origin: " + studio.origin() +
                        "\r\nTransfer-Encoding: chunked\r\n\r\n1\r\nx\r\n0\r\n\r\n",
                    411}};
  for (const auto& request : kRequests) {
    Wire wire(studio.server().port());
    wire.send(request.bytes);
    EXPECT_EQ(wire.answer().status, request.status) << request.bytes.substr(0, 80);
    EXPECT_TRUE(wire.closes_within(1s)) << request.bytes.substr(0, 80);
  }
  expect_alive(studio);
}

TEST(Dangers, AnOversizedBodyIsRefusedBeforeItIsSent) {
  Studio studio(with_folder());
  for (const char* length : {"268435457", "1073741824", "99999999999999"}) {
    Wire wire(studio.server().port());
    wire.send("POST /files?name=a.ply HTTP/1.1\r\nHost: " + studio.host() + "\r\nOrigin: " + studio.origin() +
              "\r\nCookie: " + studio.cookie() + "\r\nContent-Length: " + length + "\r\n\r\n");
    EXPECT_EQ(wire.answer().status, 413) << length;
    EXPECT_TRUE(wire.closes_within(1s));
  }
  // Without the cookie not a byte of a body is taken, however long it is.
  Wire wire(studio.server().port());
  wire.send("POST /files?name=a.ply HTTP/1.1\r\nHost: " + studio.host() + "\r\nOrigin: " + studio.origin() +
            "\r\nContent-Length: 1000000\r\n\r\n");
  EXPECT_EQ(wire.answer().status, 401);
  expect_alive(studio);
}

TEST(Dangers, SlowClientsAreDropped) {
  Studio studio(with_folder());
  Wire silent(studio.server().port()), half(studio.server().port()), body(studio.server().port());
  half.send("GET / HTTP/1.1\r\nHost: ");
  body.send("POST /files?name=slow.ply HTTP/1.1\r\nHost: " + studio.host() + "\r\nOrigin: " +
            studio.origin() + "\r\nCookie: " + studio.cookie() + "\r\nContent-Length: 100\r\n\r\nbegin");
  expect_alive(studio);
  EXPECT_TRUE(silent.closes_within(2s));
  EXPECT_TRUE(half.closes_within(2s));
  EXPECT_TRUE(body.closes_within(2s));
  EXPECT_FALSE(std::filesystem::exists(scratch() + "/work/slow.ply"));
  EXPECT_NE(studio.told().find("too slowly"), std::string::npos);
  expect_alive(studio);
}

TEST(Dangers, ManyConnectionsLeaveTheServerAlive) {
  studio::ServerOptions options = with_folder();
  options.limits.connections = 10;
  Studio studio(options);
  studio.cookie();
  std::vector<std::unique_ptr<Wire>> wires;
  for (int k = 0; k < 30; ++k) wires.push_back(std::make_unique<Wire>(studio.server().port()));
  EXPECT_TRUE(wires.back()->closes_within(1s));
  EXPECT_TRUE(wires.front()->closes_within(2s)) << "they say nothing and are dropped";
  wires.clear();
  expect_alive(studio);
}

TEST(Dangers, OneConnectionTakesManyRequests) {
  Studio studio(with_folder());
  expect_alive(studio);  // the list gives the numbers
  Wire wire(studio.server().port());
  const std::string request =
      "GET /files/0 HTTP/1.1\r\nHost: " + studio.host() + "\r\nCookie: " + studio.cookie() + "\r\n\r\n";
  wire.send(request + request);
  for (int k = 0; k < 2; ++k) EXPECT_EQ(wire.answer().body, "hull");
  wire.send("GET /files/9 HTTP/1.1\r\nHost: " + studio.host() + "\r\nCookie: " + studio.cookie() +
            "\r\n\r\n");
  EXPECT_EQ(wire.answer().status, 404);
  wire.send(request);
  EXPECT_EQ(wire.answer().body, "hull") << "a refusal does not close";
}

TEST(Server, TakesTheWantedPortOrSaysThatItIsTaken) {
  Studio studio(quick());
  studio::ServerOptions options = quick();
  options.port = studio.server().port();
  EXPECT_THROW(studio::Server{options}, InvalidInput);
  options.port.reset();
  const studio::Server usual(options), other(options);  // one of them, or somebody else, has the usual port
  EXPECT_NE(usual.port(), other.port());
  options.place = scratch() + "/nowhere";
  EXPECT_THROW(studio::Server{options}, FileError);
}

// A browser that the program has started would else keep the port taken after the end of the server.
TEST(Server, ItsSocketsAreNotForChildren) {
  Studio studio(quick());
  Wire wire(studio.server().port());
  wire.send("GET / HTTP/1.1\r\nHost: " + studio.host() + "\r\n\r\n");
  EXPECT_NE(wire.answer().status, 0);
  int n = 0;
  for (int descriptor = 3; descriptor < 256; ++descriptor) {
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) continue;
    if (address.sin_family != AF_INET || ntohs(address.sin_port) != studio.server().port()) continue;
    ++n;
    EXPECT_NE(::fcntl(descriptor, F_GETFD) & FD_CLOEXEC, 0);
  }
  EXPECT_EQ(n, 2) << "the one that listens and the one of the connection";
}

TEST(Server, NothingListensOutsideThisMachine) {
  Studio studio(quick());
  EXPECT_EQ(studio.server().url(),
            concat("http://127.0.0.1:", studio.server().port(), "/#", studio.secret()));
  // The table of sockets of the system: 0100007F is 127.0.0.1, state 0A listens.
  std::ifstream table("/proc/net/tcp");
  char port[8];
  std::snprintf(port, sizeof port, "%04X", studio.server().port());
  int n = 0;
  for (std::string line; std::getline(table, line);) {
    if (line.find(std::string(":") + port + " 00000000:0000 0A") == std::string::npos) continue;
    ++n;
    EXPECT_NE(line.find(std::string("0100007F:") + port), std::string::npos) << line;
  }
  if (n == 0) GTEST_SKIP() << "the system does not show its table of sockets";
}

}  // namespace
}  // namespace batten::test
