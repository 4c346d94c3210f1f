#include "studio/answers.hpp"

#include <string>

#include <gtest/gtest.h>

namespace batten::studio {
namespace {

/// Every combination of what a request may be, without a socket: what is not the page needs all of Host,
/// Origin and cookie.
TEST(Answers, NothingButThePageIsGivenWithoutAllThatIsNeeded) {
  Gate gate(8617);
  const Page page = Page::embedded();
  Answers answers(gate, page, nullptr, "1");
  const std::string set = gate.set_cookie();
  const std::string cookie = set.substr(0, set.find(';'));
  int n_let_in = 0;
  for (const char* method : {"GET", "HEAD", "POST", "PUT", ""})
    for (const char* target : {"/", "/files", "/files/0", "/session", "/engine", "files", ""})
      for (const bool own_host : {false, true})
        for (const int origin : {0, 1, 2})
          for (const bool has_cookie : {false, true})
            for (const bool upgrade : {false, true}) {
              Question question;
              question.method = method;
              question.target = target;
              question.host = own_host ? "localhost:8617" : "evil.example:8617";
              question.origin = origin == 0   ? ""
                                : origin == 1 ? "http://localhost:8617"
                                              : "http://evil.example";
              question.cookie = has_cookie ? cookie : "";
              question.is_upgrade = upgrade;
              if (question.method == "POST") question.body_size = 10;
              if (answers.refusal(question)) continue;
              ++n_let_in;
              EXPECT_TRUE(own_host && origin != 2) << method << target;
              const bool is_page = question.target == "/" || question.target == "/session";
              EXPECT_TRUE(is_page || has_cookie) << method << target;
              if (question.method == "POST" || upgrade) {
                EXPECT_EQ(origin, 1) << method << target;
              }
              EXPECT_EQ(upgrade, question.target == "/engine");
            }
  EXPECT_GT(n_let_in, 20);
}

TEST(Answers, EveryAnswerCarriesTheRulesForThePage) {
  Answer answer = sentence_answer(404, "no \"such\" file");
  add_common_headers(answer);
  std::string all;
  for (const auto& [name, value] : answer.headers) all += name + ": " + value + "\n";
  for (const char* part :
       {"default-src 'self';", "script-src 'self' 'wasm-unsafe-eval';", "object-src 'none';",
        "frame-ancestors 'none'", "X-Content-Type-Options: nosniff",
        "Cross-Origin-Opener-Policy: same-origin", "Cross-Origin-Embedder-Policy: require-corp"})
    EXPECT_NE(all.find(part), std::string::npos) << part;
  EXPECT_EQ(all.find("Access-Control"), std::string::npos);
  EXPECT_EQ(all.find("unsafe-inline"), std::string::npos);
  EXPECT_NE(answer.text.find("no \\\"such\\\" file"), std::string::npos);
}

}  // namespace
}  // namespace batten::studio
