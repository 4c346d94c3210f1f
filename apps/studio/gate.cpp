#include "studio/gate.hpp"

#include <array>
#include <cerrno>
#include <cstddef>

#include <sys/random.h>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"

namespace batten::studio {

std::string random_secret() {
  std::array<unsigned char, 16> bytes{};
  std::size_t n = 0;
  while (n < bytes.size()) {
    const ssize_t got = getrandom(bytes.data() + n, bytes.size() - n, 0);
    if (got < 0 && errno != EINTR) throw Error("the system gives no random numbers");
    if (got > 0) n += static_cast<std::size_t>(got);
  }
  std::string text;
  for (const unsigned char byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

bool equal_in_constant_time(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;  // volatile: no compiler may end the loop early
  for (std::size_t k = 0; k < a.size(); ++k)
    difference = static_cast<unsigned char>(difference | static_cast<unsigned char>(a[k] ^ b[k]));
  return difference == 0;
}

Gate::Gate(unsigned short port)
    : port_(port),
      secret_(random_secret()),
      // Cookies do not know ports: two studios at a time must not overwrite each other's.
      cookie_name_(concat("batten-", port)),
      token_(random_secret()) {}

bool Gate::is_own_host(std::string_view host) const {
  for (const char* name : {"127.0.0.1", "localhost", "[::1]"})
    if (lower_case(host) == concat(name, ":", port_)) return true;
  return false;
}

bool Gate::is_own_origin(std::string_view origin, std::string_view host) {
  return !host.empty() && lower_case(origin) == "http://" + lower_case(host);
}

Gate::Trade Gate::trade(std::string_view secret) {
  if (!equal_in_constant_time(secret, secret_)) return Trade::Wrong;
  if (traded_) return Trade::Used;
  traded_ = true;
  return Trade::Done;
}

std::string Gate::set_cookie() const {
  return concat(cookie_name_, "=", token_, "; Path=/; HttpOnly; SameSite=Strict");
}

bool Gate::admits(std::string_view cookies) const {
  bool found = false;
  for (const std::string_view cookie : split_fields(cookies, ';')) {
    const std::size_t sign = cookie.find('=');
    if (sign == std::string_view::npos || cookie.substr(0, sign) != cookie_name_) continue;
    if (equal_in_constant_time(cookie.substr(sign + 1), token_)) found = true;
  }
  return found;
}

}  // namespace batten::studio
