#include "studio/gate.hpp"

#include <set>
#include <string>

#include <gtest/gtest.h>

namespace batten::studio {
namespace {

TEST(Gate, SecretsHave128BitsAndAreNeverTheSame) {
  std::set<std::string> seen;
  for (int k = 0; k < 100; ++k) {
    const std::string secret = random_secret();
    EXPECT_EQ(secret.size(), 32U);
    EXPECT_EQ(secret.find_first_not_of("0123456789abcdef"), std::string::npos);
    EXPECT_TRUE(seen.insert(secret).second);
  }
}

TEST(Gate, ComparesWholeTexts) {
  EXPECT_TRUE(equal_in_constant_time("", ""));
  EXPECT_TRUE(equal_in_constant_time("abc", "abc"));
  EXPECT_FALSE(equal_in_constant_time("abc", "abd"));
  EXPECT_FALSE(equal_in_constant_time("abc", "bbc"));
  EXPECT_FALSE(equal_in_constant_time("abc", "ab"));
  EXPECT_FALSE(equal_in_constant_time("", "a"));
}

TEST(Gate, KnowsTheNamesOfThisMachineAndItsPortAlone) {
  const Gate gate(8617);
  for (const char* host : {"127.0.0.1:8617", "localhost:8617", "LocalHost:8617", "[::1]:8617"})
    EXPECT_TRUE(gate.is_own_host(host)) << host;
  for (const char* host :
       {"", "127.0.0.1", "localhost", "127.0.0.1:80", "127.0.0.1:86170", "evil.example:8617",
        "localhost.evil.example:8617", "127.0.0.1:8617.evil.example", "127.0.0.1:8617 ", "0.0.0.0:8617",
        "[::]:8617", "user@127.0.0.1:8617", "localhost.:8617", "2130706433:8617"})
    EXPECT_FALSE(gate.is_own_host(host)) << host;
}

TEST(Gate, TheOriginIsThatOfTheHost) {
  EXPECT_TRUE(Gate::is_own_origin("http://127.0.0.1:8617", "127.0.0.1:8617"));
  EXPECT_TRUE(Gate::is_own_origin("http://localhost:8617", "Localhost:8617"));
  for (const char* origin : {"", "null", "https://127.0.0.1:8617", "http://127.0.0.1",
                             "http://127.0.0.1:8618", "http://localhost:8617", "http://127.0.0.1:8617/",
                             "http://127.0.0.1:8617.evil.example", "http://evil.example"})
    EXPECT_FALSE(Gate::is_own_origin(origin, "127.0.0.1:8617")) << origin;
  EXPECT_FALSE(Gate::is_own_origin("http://", ""));
}

TEST(Gate, TheSecretIsGoodForOneTrade) {
  Gate gate(8617);
  EXPECT_EQ(gate.trade(""), Gate::Trade::Wrong);
  EXPECT_EQ(gate.trade(gate.secret() + "0"), Gate::Trade::Wrong);
  EXPECT_EQ(gate.trade(gate.secret()), Gate::Trade::Done);
  EXPECT_EQ(gate.trade(gate.secret()), Gate::Trade::Used);
  EXPECT_EQ(gate.trade("0"), Gate::Trade::Wrong);
}

TEST(Gate, AdmitsItsCookieAmongOthers) {
  const Gate gate(8617), other(8618);
  const std::string set = gate.set_cookie();
  EXPECT_NE(set.find("; HttpOnly"), std::string::npos);
  EXPECT_NE(set.find("; SameSite=Strict"), std::string::npos);
  const std::string cookie = set.substr(0, set.find(';'));
  EXPECT_EQ(cookie.substr(0, 12), "batten-8617=");
  EXPECT_EQ(cookie.find(gate.secret()), std::string::npos) << "who knows the one does not know the other";
  EXPECT_TRUE(gate.admits(cookie));
  EXPECT_TRUE(gate.admits("a=b; " + cookie + "; batten-8618=0"));
  EXPECT_TRUE(gate.admits("batten-8617=old; " + cookie)) << "a page cannot lock itself out";
  for (const std::string& cookies :
       {std::string(), cookie.substr(12), "x" + cookie, cookie + "0", std::string("batten-8617="),
        std::string("batten-8617"), "batten-8617=" + gate.secret(), std::string(";;;=;=")})
    EXPECT_FALSE(gate.admits(cookies)) << cookies;
  EXPECT_FALSE(other.admits(cookie));
}

}  // namespace
}  // namespace batten::studio
