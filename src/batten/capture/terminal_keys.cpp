#include "batten/capture/terminal_keys.hpp"

#include <cctype>

#include <poll.h>
#include <termios.h>
#include <unistd.h>

namespace batten {

struct TerminalKeys::Implementation {
  bool is_terminal = false, over = false;
  termios before{};
};

TerminalKeys::TerminalKeys() : implementation_(std::make_unique<Implementation>()) {
  if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &implementation_->before) != 0) return;
  // A program in the background may not change its terminal: it would be stopped.
  if (::tcgetpgrp(STDIN_FILENO) != ::getpgrp()) return;
  termios raw = implementation_->before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  implementation_->is_terminal = ::tcsetattr(STDIN_FILENO, TCSANOW, &raw) == 0;
}

TerminalKeys::~TerminalKeys() {
  if (implementation_->is_terminal) ::tcsetattr(STDIN_FILENO, TCSANOW, &implementation_->before);
}

std::vector<std::string> TerminalKeys::read() {
  if (implementation_->over) return {};
  pollfd waited{STDIN_FILENO, POLLIN, 0};
  if (::poll(&waited, 1, 0) <= 0) return {};
  char buffer[256];
  const ssize_t n = ::read(STDIN_FILENO, buffer, sizeof buffer);
  if (n <= 0) {
    implementation_->over = true;
    return {};
  }
  return keys_of({buffer, static_cast<std::size_t>(n)});
}

std::vector<std::string> keys_of(std::string_view bytes) {
  constexpr std::string_view kKeys = "+-0123456789./*q";
  std::vector<std::string> keys;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const char c = bytes[i];
    if (c == '\n' || c == '\r') {
      keys.emplace_back("enter");
    } else if (c == '\x7f' || c == '\b') {
      keys.emplace_back("backspace");
    } else if (c == '\x1b' && i + 1 < bytes.size() && (bytes[i + 1] == '[' || bytes[i + 1] == 'O')) {
      // Up to the letter or ~ that ends the sequence.
      for (i += 2;
           i < bytes.size() && std::isalpha(static_cast<unsigned char>(bytes[i])) == 0 && bytes[i] != '~';)
        ++i;
    } else if (kKeys.find(c) != std::string_view::npos) {
      keys.emplace_back(1, c);
    }
  }
  return keys;
}

}  // namespace batten
