#include "studio/answers.hpp"

#include "studio/frames.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "batten/core/text.hpp"

namespace batten::studio {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostSecret = 1024;  // the body of POST /session

Answer json_answer(int status, const Json& json) {
  Answer answer;
  answer.status = status;
  answer.headers = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}};
  answer.text = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  return answer;
}

Answer refused(int status, std::string_view sentence) {
  Answer answer = sentence_answer(status, sentence);
  answer.refused = sentence;
  return answer;
}

std::string_view path_of(const Question& question) {
  const std::string_view target = question.target;
  return target.substr(0, target.find('?'));
}

std::string_view query_of(const Question& question) {
  const std::size_t mark = question.target.find('?');
  return mark == std::string::npos ? std::string_view() : std::string_view(question.target).substr(mark + 1);
}

int hexadecimal(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// A value of a query, decoded once; nothing where it is missing or its escapes are damaged.
std::optional<std::string> value_of(std::string_view query, std::string_view name) {
  for (const std::string_view part : split_fields(query, '&')) {
    const std::size_t sign = part.find('=');
    if (part.substr(0, sign) != name || sign == std::string_view::npos) continue;
    std::string value;
    for (std::size_t k = sign + 1; k < part.size(); ++k) {
      if (part[k] == '%') {
        if (k + 2 >= part.size()) return std::nullopt;
        const int high = hexadecimal(part[k + 1]), low = hexadecimal(part[k + 2]);
        if (high < 0 || low < 0) return std::nullopt;
        value += static_cast<char>(16 * high + low);
        k += 2;
      } else {
        value += part[k] == '+' ? ' ' : part[k];
      }
    }
    return value;
  }
  return std::nullopt;
}

bool is_socket_path(std::string_view path) {
  return path == "/engine" || path == "/capture";
}

bool is_file_path(std::string_view path) {
  return path == "/files" || path.substr(0, 7) == "/files/";
}

/// The number of "/files/12"; -1 where it is none.
long number_of(std::string_view path) {
  const std::string_view digits = path.substr(std::string_view("/files/").size());
  long number = 0;
  if (digits.empty() || digits.size() > 6 || digits.find_first_not_of("0123456789") != std::string_view::npos)
    return -1;
  return parse_integer(digits, number) ? number : -1;
}

/// The methods that a path knows, as a header Allow names them.
std::string methods_of(std::string_view path) {
  if (path == "/session" || path == "/files") return "GET, HEAD, POST";
  return "GET, HEAD";
}

bool knows_method(std::string_view path, const std::string& method) {
  const std::string known = methods_of(path);
  const std::vector<std::string_view> list = split_fields(known, ',');
  return std::find(list.begin(), list.end(), method) != list.end();
}

std::size_t most_body(const Question& question) {
  if (question.method != "POST") return 0;
  return path_of(question) == "/files" ? kMostUpload : kMostSecret;
}

/// Whether a list such as `"a", W/"b"` or `*` names the tag.
bool names_tag(std::string_view list, const std::string& tag) {
  for (std::string_view entry : split_fields(list, ',')) {
    if (entry.substr(0, 2) == "W/") entry.remove_prefix(2);
    if (entry == "*" || entry == tag) return true;
  }
  return false;
}

bool accepts_gzip(std::string_view list) {
  for (const std::string_view entry : split_fields(list, ',')) {
    const std::vector<std::string_view> parts = split_fields(entry, ';');
    if (lower_case(parts[0]) != "gzip") continue;
    return parts.size() < 2 || (parts[1] != "q=0" && parts[1].substr(0, 5) != "q=0.0");
  }
  return false;
}

}  // namespace

bool is_capture_socket(const Question& question) {
  return path_of(question) == "/capture";
}

Answer sentence_answer(int status, std::string_view sentence) {
  return json_answer(status, {{"ok", false}, {"message", sentence}});
}

void add_common_headers(Answer& answer) {
  static const std::pair<const char*, const char*> kHeaders[] = {
      {"Content-Security-Policy",
       "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; connect-src 'self'; "
       "img-src 'self' blob: data:; object-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action "
       "'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cross-Origin-Embedder-Policy", "require-corp"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Referrer-Policy", "no-referrer"}};
  for (const auto& [name, value] : kHeaders) answer.headers.emplace_back(name, value);
}

Answers::Answers(Gate& gate, const Page& page, Folder* folder, std::string version)
    : gate_(gate), page_(page), folder_(folder), version_(std::move(version)) {}

std::optional<Answer> Answers::refusal(const Question& q) const {
  if (q.is_ambiguous) return refused(400, "a header that may stand once stands twice");
  if (!gate_.is_own_host(q.host)) return refused(421, "the Host is not that of this server");
  if (q.target.empty() || q.target[0] != '/') return refused(400, "the target is no path");
  const std::string_view path = path_of(q);
  const bool reads = q.method == "GET" || q.method == "HEAD";
  // Browsers leave the Origin out where a page reads from where it came; what is there must be right.
  if ((!reads || q.is_upgrade || !q.origin.empty()) && !Gate::is_own_origin(q.origin, q.host))
    return refused(403, "the Origin is not that of the page of this server");
  if (!knows_method(path, q.method)) {
    Answer answer = refused(405, "the method does not exist here");
    answer.headers.emplace_back("Allow", methods_of(path));
    return answer;
  }
  if (q.is_upgrade != is_socket_path(path)) {
    if (q.is_upgrade) return refused(404, "there is no socket of this name");
    Answer answer = sentence_answer(426, "this is a socket; see docs/studio-server.md");
    answer.headers.emplace_back("Upgrade", "websocket");
    return answer;
  }
  if ((q.is_upgrade || is_file_path(path)) && !gate_.admits(q.cookie))
    return refused(401, "this window was not opened by the address that batten studio printed");
  if (q.is_chunked || (q.method == "POST" && !q.body_size)) return refused(411, "a body needs its length");
  if (q.body_size.value_or(0) > most_body(q))
    return refused(413, concat("the body is longer than ", most_body(q), " bytes"));
  return std::nullopt;
}

Answer Answers::answer(const Question& question, std::string_view body) {
  const std::string_view path = path_of(question);
  if (path == "/session") return session_answer(question, body);
  if (is_file_path(path)) return files_answer(question, body);
  return page_answer(question);
}

OpenedBytes Answers::open_file(std::uint32_t number) const {
  return folder_ == nullptr ? OpenedBytes() : folder_->open(number);
}

std::string Answers::session_json() const {
  Json json = {{"ok", true}, {"version", version_}, {"engine", true}};
  json["folder"] = folder_ == nullptr ? Json(nullptr) : Json(folder_->name());
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Answer Answers::session_answer(const Question& question, std::string_view body) {
  Answer answer;
  answer.headers = {{"Content-Type", "application/json"}, {"Cache-Control", "no-store"}};
  // A window that is loaded again trades its secret again: it has the cookie.
  const bool is_in = gate_.admits(question.cookie);
  if (question.method != "POST" || is_in) {
    if (!is_in) return sentence_answer(401, "open the address that batten studio printed");
    answer.text = session_json();
    return answer;
  }
  const Json json = Json::parse(body, nullptr, false);
  const auto secret = json.is_object() ? json.find("secret") : json.end();
  if (secret == json.end() || !secret->is_string())
    return refused(400, "the body must be {\"secret\":\"…\"}");
  switch (gate_.trade(secret->get<std::string>())) {
    case Gate::Trade::Wrong:
      return refused(403, "the secret is wrong; open the address that batten studio printed");
    case Gate::Trade::Used:
      return refused(403, "the address was used by another browser; start batten studio again");
    case Gate::Trade::Done:
      break;
  }
  answer.headers.emplace_back("Set-Cookie", gate_.set_cookie());
  answer.text = session_json();
  return answer;
}

Answer Answers::files_answer(const Question& question, std::string_view body) {
  if (folder_ == nullptr) {
    if (question.method == "POST" || path_of(question) != "/files")
      return sentence_answer(404, "batten studio was started without a folder; start it with one");
    return json_answer(200, {{"folder", nullptr}, {"files", Json::array()}, {"left_out", 0}});
  }
  const std::string_view path = path_of(question), query = query_of(question);
  if (question.method == "POST") {
    const auto name = value_of(query, "name");
    if (!name) return sentence_answer(400, "the name of the file is missing: POST /files?name=hull.ply");
    const Written written = folder_->write(*name, body, value_of(query, "replace") == "1");
    switch (written.outcome) {
      case Written::Outcome::BadName:
        return refused(400, written.sentence);
      case Written::Outcome::Exists:
        return sentence_answer(409, written.sentence);
      case Written::Outcome::Failed:
        return sentence_answer(500, written.sentence);
      case Written::Outcome::Done:
        break;
    }
    return json_answer(201,
                       {{"ok", true}, {"number", written.number}, {"name", *name}, {"size", body.size()}});
  }
  if (path == "/files") {
    const Listing listing = folder_->list();
    Json files = Json::array();
    for (const ListedFile& file : listing.files)
      files.push_back({{"number", file.number}, {"name", file.name}, {"size", file.size}});
    const auto first = folder_->first();
    return json_answer(200, {{"folder", folder_->name()},
                             {"open", first ? Json(*first) : Json(nullptr)},
                             {"files", files},
                             {"left_out", listing.left_out}});
  }
  Answer answer;
  answer.file = folder_->open(number_of(path));
  if (!answer.file.descriptor.is_open()) return refused(404, "there is no file of this number");
  answer.headers = {{"Content-Type", "application/octet-stream"},
                    {"Cache-Control", "no-store"},
                    {"Content-Disposition", "attachment"}};
  return answer;
}

Answer Answers::page_answer(const Question& question) const {
  Answer answer;
  const std::string_view path = path_of(question).substr(1);
  if (page_.is_empty() && (path.empty() || path == "index.html")) {
    answer.status = 503;
    answer.headers = {{"Content-Type", mime_type("index.html")}, {"Cache-Control", "no-store"}};
    answer.bytes = no_page_html();
    return answer;
  }
  const PageFile* file = page_.find(path);
  if (file == nullptr) return sentence_answer(404, "there is no file of this name in the page");
  const bool packed = !file->gzip.empty() && accepts_gzip(question.accept_encoding);
  const std::string tag = concat("\"", file->tag, packed ? "-gz\"" : "\"");
  answer.headers = {
      {"ETag", tag},
      {"Vary", "Accept-Encoding"},
      // The names below assets/ hold a hash of the content.
      {"Cache-Control", path.substr(0, 7) == "assets/" ? "public, max-age=31536000, immutable" : "no-cache"}};
  if (names_tag(question.if_none_match, tag)) {
    answer.status = 304;
    return answer;
  }
  answer.headers.emplace_back("Content-Type", file->type);
  if (packed) answer.headers.emplace_back("Content-Encoding", "gzip");
  answer.bytes = packed ? file->gzip : file->bytes;
  return answer;
}

}  // namespace batten::studio
