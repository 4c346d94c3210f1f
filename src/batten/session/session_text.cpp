#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/file.hpp"
#include "batten/session/durable_file_detail.hpp"
#include "batten/session/edit_json.hpp"
#include "batten/session/edit_json_detail.hpp"
#include "batten/session/session_text_detail.hpp"

namespace batten {

namespace {

/// Whether a text may be the beginning of a header that was not finished.
bool begins_as_header(std::string_view text) {
  constexpr std::string_view kBegin = R"({"batten_session":)";
  return text.substr(0, kBegin.size()) == kBegin.substr(0, text.size());
}

void begin(Session& session, const SessionHeader& header, long line) {
  session.format = header.format;
  if (header.format != 1) return;
  session.edits.push_back({line, AddEdit{ObjectId{1}, "model", header.unit, SharedModel()}});
  session.edits.push_back({line, CheckpointEdit{}});
  session.n_implied = session.edits.size();
}

Edit edit_in(std::string_view line, int format, const std::function<void(detail::Json&)>& resolve) {
  if (format == 1) return parse_edit_of_format_1(line);
  if (!resolve) return parse_edit(line);
  detail::Json json = detail::parse_json(line);
  resolve(json);
  return detail::edit_of(json);
}

}  // namespace

Session detail::parse_session(const std::string& text, const std::string& path,
                              const std::function<void(Json&)>& resolve) {
  Session session;
  bool has_header = false;
  long line_number = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const bool unfinished = end == std::string::npos;
    const std::string_view line =
        trim(std::string_view(text).substr(at, unfinished ? std::string::npos : end - at));
    at = unfinished ? text.size() : end + 1;
    ++line_number;
    if (line.empty()) continue;
    // A whole value needs no end of line.
    if (unfinished && (has_header || begins_as_header(line)) && !is_whole_json(line)) {
      session.torn = true;
      session.torn_line = line_number;
      return session;
    }
    try {
      if (has_header)
        session.edits.push_back({line_number, edit_in(line, session.format, resolve)});
      else
        begin(session, parse_session_header(line), line_number);
    } catch (const InvalidInput& error) {
      throw FileError(path, line_number, error.what());
    }
    has_header = true;
  }
  if (!has_header)
    throw FileError(path, 0, "the file is empty; a journal begins with " + format_session_header());
  return session;
}

std::string Session::warning(const std::string& path) const {
  if (!torn) return "";
  return concat(path, ":", torn_line,
                ": the last line is not finished; the edit that was being written is lost");
}

Session parse_session(const std::string& text, const std::string& path) {
  return detail::parse_session(text, path, {});
}

Session read_session(const std::string& path) {
  return parse_session(read_file(path), path);
}

std::string format_session(const std::vector<Edit>& edits) {
  std::string text = format_session_header() + '\n';
  for (const Edit& edit : edits) text += format_edit(edit) + '\n';
  return text;
}

void write_session(const std::string& path, const std::vector<Edit>& edits) {
  detail::write_durably(path, format_session(edits));
}

}  // namespace batten
