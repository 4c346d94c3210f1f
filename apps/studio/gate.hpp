#pragma once
#include <string>
#include <string_view>

// Who may speak to the server. Decisions only, each a function of text: docs/studio-server.md#safety.
namespace batten::studio {

/// 128 bits from the operating system as 32 hexadecimal digits.
/// @throws Error where the system has none to give.
std::string random_secret();

/// Whether two texts are equal, in a time that depends on their lengths alone.
bool equal_in_constant_time(std::string_view a, std::string_view b);

/// The gate of one run of the server: its names, the secret of the address that is opened, and the cookie
/// that the secret is traded for.
class Gate {
 public:
  explicit Gate(unsigned short port);

  /// Whether a Host names this machine and the port; other names lead here by DNS rebinding alone.
  bool is_own_host(std::string_view host) const;
  /// Whether an Origin is that of a page which was loaded from this host.
  static bool is_own_origin(std::string_view origin, std::string_view host);

  /// The secret in the address; good for one trade.
  const std::string& secret() const { return secret_; }
  enum class Trade { Done, Wrong, Used };
  Trade trade(std::string_view secret);

  /// The value of Set-Cookie after a trade.
  std::string set_cookie() const;
  /// Whether a header Cookie holds the cookie of this run.
  bool admits(std::string_view cookies) const;

 private:
  unsigned short port_;
  std::string secret_, cookie_name_, token_;
  bool traded_ = false;
};

}  // namespace batten::studio
