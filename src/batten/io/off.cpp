#include <algorithm>
#include <limits>

#include "batten/core/error.hpp"
#include "batten/core/text.hpp"
#include "batten/io/mesh_formats_detail.hpp"

namespace batten::detail {

namespace {

/// The next line that holds more than blanks and a comment.
std::string_view next_content(LineReader& reader, std::string_view expected) {
  std::string_view line;
  while (reader.next(line)) {
    line = trim(without_comment(line));
    if (!line.empty()) return line;
  }
  throw FileError(reader.path(), reader.line_number(),
                  concat("the file ends before ", expected, "; it is truncated or its counts are wrong"));
}

}  // namespace

RawMesh parse_off(std::string content, const std::string& path) {
  RawMesh mesh;
  const size_t size = content.size();
  LineReader reader(std::move(content), path);
  std::string_view line = next_content(reader, "the counts");
  bool has_normals = false;
  std::vector<std::string_view> words = split_blanks(line);
  long ignored = 0;
  if (!parse_integer(words[0], ignored)) {  // without a keyword the counts come first
    const std::string_view keyword = words[0];
    if (keyword != "OFF" && keyword != "COFF" && keyword != "NOFF" && keyword != "CNOFF" &&
        keyword != "NCOFF" && keyword != "STOFF")
      reader.fail("expected the keyword OFF, COFF or NOFF; is this an OFF file of three dimensions?");
    if (words.size() > 1 && words[1] == "BINARY")
      reader.fail("binary OFF is not read; export it as text or as PLY");
    has_normals = keyword.find('N') != std::string_view::npos;
    line = words.size() > 1 ? line.substr(keyword.size()) : next_content(reader, "the counts");
  }
  Tokens counts(line);
  const long most = std::numeric_limits<int>::max() / 3;
  const long n_vertices = read_integer(counts, reader, "the number of vertices", 0, most);
  const long n_faces = read_integer(counts, reader, "the number of faces", 0, most);
  // A vertex takes six bytes at least, a face two: the counts are held against the size before memory is
  // taken.
  if (static_cast<double>(n_vertices) * 6 + static_cast<double>(n_faces) * 2 > static_cast<double>(size) + 2)
    reader.fail(concat(n_vertices, " vertices and ", n_faces, " faces do not fit into ", size,
                       " bytes; the file is truncated or its counts are wrong"));
  mesh.positions.reserve(3 * static_cast<size_t>(n_vertices));
  for (long v = 0; v < n_vertices; ++v) {
    Tokens tokens(next_content(reader, concat("vertex ", v, " of ", n_vertices)));
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(read_finite(tokens, reader, "a coordinate"));
    if (has_normals)
      for (int k = 0; k < 3; ++k)
        mesh.normals.push_back(read_finite(tokens, reader, "a coordinate of the normal"));
  }
  std::vector<int> corners;
  for (long f = 0; f < n_faces; ++f) {
    Tokens tokens(next_content(reader, concat("face ", f, " of ", n_faces)));
    const long n_corners = read_integer(tokens, reader, "the number of corners", 0, most);
    corners.clear();
    for (long k = 0; k < n_corners; ++k)
      corners.push_back(static_cast<int>(read_integer(tokens, reader, "a corner", 0, n_vertices - 1)));
    add_face(mesh, corners);
  }
  while (reader.next(line))
    if (!trim(without_comment(line)).empty())
      reader.fail(concat("more lines follow than the ", n_vertices, " vertices and ", n_faces,
                         " faces announced; correct the counts"));
  return mesh;
}

}  // namespace batten::detail
